#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/bag_file.hpp"
#include "input/log_table.hpp"

namespace qerr {

namespace {

/// Reads the fields of a message one after the other: CDR, whose numbers are aligned behind a header of four
/// bytes with the byte order, or ROS 1, little-endian without gaps.
class FieldReader {
 public:
  FieldReader(std::string_view data, bool ros1) : data_(data), aligned_(!ros1) {
    if (ros1) return;
    big_ = take(4)[1] % 2 == 0;
    data_.remove_prefix(4);
    at_ = 0;
  }

  template <class Number>
  Number number() {
    if (aligned_) at_ += (sizeof(Number) - at_ % sizeof(Number)) % sizeof(Number);
    std::string bytes(take(sizeof(Number)));
    if (big_ != (std::endian::native == std::endian::big)) std::ranges::reverse(bytes);
    Number value;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }

  /// Without the zero that ends it in CDR.
  std::string text() {
    std::string_view bytes = take(number<std::uint32_t>());
    if (bytes.ends_with('\0')) bytes.remove_suffix(1);
    return std::string(bytes);
  }

  std::vector<double> numbers() {
    const auto count = number<std::uint32_t>();
    if (count > data_.size() / sizeof(double)) throw std::range_error("a list is longer than its message");
    std::vector<double> all(count);
    for (double& x : all) x = number<double>();
    return all;
  }

  /// Time stamp and frame of a header [ns]; empty for zero.
  std::optional<std::int64_t> header() {
    if (!aligned_) number<std::uint32_t>();  // the sequence number of ROS 1
    const auto seconds = number<std::int32_t>();
    const auto nanoseconds = number<std::uint32_t>();
    text();
    if (seconds == 0 && nanoseconds == 0) return std::nullopt;
    return std::int64_t{seconds} * 1'000'000'000 + nanoseconds;
  }

  void skip(std::size_t bytes) { take(bytes); }

 private:
  std::string_view take(std::size_t count) {
    if (at_ > data_.size() || count > data_.size() - at_) throw std::range_error("a message ends too early");
    at_ += count;
    return data_.substr(at_ - count, count);
  }

  std::string_view data_;
  std::size_t at_ = 0;
  bool aligned_, big_ = false;
};

void add_point(FieldReader& in, const std::string& name, BagSample& sample) {
  for (const char* axis : {"/x", "/y", "/z"}) sample.values.emplace_back(name + axis, in.number<double>());
}

using Samples = std::vector<BagSample>;

void joint_state(FieldReader& in, const std::string& topic, Samples& samples) {
  BagSample sample{topic, in.header(), {}};
  std::vector<std::string> names(std::min<std::uint32_t>(in.number<std::uint32_t>(), 10'000));
  for (std::string& name : names) name = in.text();
  for (const char* quantity : {"/position", "/velocity", "/effort"}) {
    const std::vector<double> values = in.numbers();  // may be empty, where nothing is known
    for (std::size_t i = 0; i < std::min(values.size(), names.size()); ++i)
      sample.values.emplace_back(topic + '/' + names[i] + quantity, values[i]);
  }
  // Several drivers may publish on one topic, each its own joints at its own instants.
  if (!names.empty()) sample.stream += '/' + names.front();
  samples.push_back(std::move(sample));
}

/// A position behind a header. @param path  of its column, behind the topic
void add_position(FieldReader& in, const std::string& topic, const char* path, Samples& samples,
                  bool of_frame = false) {
  BagSample sample{topic, in.header(), {}};
  if (of_frame) in.text();
  add_point(in, topic + path, sample);
  samples.push_back(std::move(sample));
}

void pose(FieldReader& in, const std::string& topic, Samples& samples) {
  add_position(in, topic, "/pose/position", samples);
}

/// PoseWithCovarianceStamped has a pose in its pose.
void covariant_pose(FieldReader& in, const std::string& topic, Samples& samples) {
  add_position(in, topic, "/pose/pose/position", samples);
}

void odometry(FieldReader& in, const std::string& topic, Samples& samples) {
  add_position(in, topic, "/pose/pose/position", samples, true);
}

void point(FieldReader& in, const std::string& topic, Samples& samples) {
  add_position(in, topic, "/point", samples);
}

void transform(FieldReader& in, const std::string& topic, Samples& samples) {
  BagSample sample{topic, in.header(), {}};
  sample.stream += '/' + in.text();
  add_point(in, sample.stream + "/translation", sample);
  for (int i = 0; i < 4; ++i) in.number<double>();
  samples.push_back(std::move(sample));
}

void transforms(FieldReader& in, const std::string& topic, Samples& samples) {
  for (auto count = in.number<std::uint32_t>(); count > 0; --count) transform(in, topic, samples);
}

template <class Number>
void scalar(FieldReader& in, const std::string& topic, Samples& samples) {
  samples.push_back({topic, {}, {{topic + "/data", static_cast<double>(in.number<Number>())}}});
}

void array(FieldReader& in, const std::string& topic, Samples& samples) {
  for (auto dimensions = in.number<std::uint32_t>(); dimensions > 0; --dimensions) {
    in.text();
    in.number<std::uint32_t>(), in.number<std::uint32_t>();
  }
  in.number<std::uint32_t>();
  BagSample sample{topic, {}, {}};
  for (const double value : in.numbers())
    sample.values.emplace_back(topic + "/data/" + std::to_string(sample.values.size()), value);
  samples.push_back(std::move(sample));
}

/// A type of messages, without `msg/`.
struct MessageType {
  std::string_view name;
  void (*decode)(FieldReader&, const std::string& topic, Samples&);
};
constexpr MessageType message_types[]{
    {"sensor_msgs/JointState", joint_state},
    {"geometry_msgs/PoseStamped", pose},
    {"geometry_msgs/PoseWithCovarianceStamped", covariant_pose},
    {"geometry_msgs/PointStamped", point},
    {"geometry_msgs/TransformStamped", transform},
    {"tf2_msgs/TFMessage", transforms},
    {"nav_msgs/Odometry", odometry},
    {"std_msgs/Float64", scalar<double>},
    {"std_msgs/Float32", scalar<float>},
    {"std_msgs/Int64", scalar<std::int64_t>},
    {"std_msgs/Int32", scalar<std::int32_t>},
    {"std_msgs/Float64MultiArray", array},
};

const MessageType* find_type(std::string_view type) {
  std::string plain(type);
  if (const std::size_t at = plain.find("/msg/"); at != std::string::npos) plain.erase(at, 4);
  return find_named(message_types, plain);
}

/// Whether messages of a type are decoded: JointState, poses, points, transforms, single numbers.
bool is_decoded(std::string_view type) { return find_type(type) != nullptr; }

/// Decodes a message; names are those that PlotJuggler gives: `TOPIC/JOINT/position`,
/// `TOPIC/pose/position/x`, `TOPIC/CHILD_FRAME/translation/x`, `TOPIC/data`.
/// @throws std::range_error for one that ends too early
void decode_message(const BagMessage& message, std::vector<BagSample>& samples) {
  samples.clear();
  FieldReader in(message.data, message.ros1);
  if (const MessageType* type = find_type(message.type))
    type->decode(in, std::string(message.topic), samples);
}

constexpr std::size_t most_texts = 1000;  // kept of each signal, for a proposal of the mapping

/// The signals of samples that follow each other: a topic, or a part of it.
struct BagStream {
  std::string topic;
  std::vector<std::string> names;
  std::vector<std::vector<std::string>> texts;  // of the first values
  std::uint64_t samples = 0, stamped = 0;       // with a stamp in the header
};

[[noreturn]] void refuse_message(const std::string& file, const BagMessage& message, const char* why) {
  throw Error({file, 0, 0}, std::string(message.topic),
              "a message of " + std::string(message.type) + " is damaged: " + why, "", "");
}

void decode_checked(const std::string& file, const BagMessage& message, std::vector<BagSample>& samples) {
  try {
    decode_message(message, samples);
  } catch (const std::range_error& e) {
    refuse_message(file, message, e.what());
  }
}

TimeStamp stamp_of(std::int64_t nanoseconds) {
  constexpr std::int64_t second = 1'000'000'000;
  return {nanoseconds / second, nanoseconds % second * second};
}

/// One stream of a bag, which is read again from the file.
class BagSamples : public LogSamples {
 public:
  BagSamples(const std::string& path, std::string stream, BagStream found, std::vector<std::string> warnings,
             const LogReading& reading, LogClock& clock)
      : LogSamples(path),
        stream_(std::move(stream)),
        found_(std::move(found)),
        warnings_(std::move(warnings)),
        clock_(clock) {
    time_ = 0;
    signals_.push_back({"time [s]", {file_, 0, 0}, {"time", "s", false}});
    const std::vector<ColumnMeaning> meanings = column_meanings(found_.names, reading);
    for (std::size_t i = 0; i < found_.names.size(); ++i) {
      signals_.push_back({found_.names[i], {file_, 0, 0}, meanings[i]});
      index_[found_.names[i]] = i + 1;
    }
  }

  std::string name() const override { return file_ + ' ' + stream_; }

  void choose(const std::vector<std::size_t>& signals) override {
    chosen_ = signals;
    places_.assign(signals_.size(), -1);
    for (std::size_t i = 0; i < signals.size(); ++i) places_[signals[i]] = static_cast<std::ptrdiff_t>(i);
    values_.assign(signals.size(), std::nan(""));
    if (!signals.empty()) bag_ = open_bag(file_, found_.topic);
  }

  bool next(double& time, double* values) override {
    while (at_ == samples_.size() || samples_[at_].stream != stream_) {
      if (at_ < samples_.size()) {
        ++at_;
        continue;
      }
      if (!bag_ || !bag_->next(message_)) return false;
      decode_checked(file_, message_, samples_);
      at_ = 0;
    }
    const BagSample& sample = samples_[at_++];
    ++number_;
    time = clock_.seconds(
        stamp_of(uses_header() ? sample.stamp.value_or(message_.received) : message_.received));
    if (last_ && time < *last_)
      throw Error({file_, 0, 0}, stream_,
                  "time must not decrease, after " + shortest(clock_.origin() + *last_) + " s",
                  shortest(clock_.origin() + time),
                  "do two publishers share the topic, or was a simulated clock started again?");
    last_ = time;
    std::fill_n(values, chosen_.size(), std::nan(""));
    for (const auto& [name, value] : sample.values) {
      const auto found = index_.find(name);
      const std::ptrdiff_t place = found == index_.end() ? -1 : places_[found->second];
      if (place < 0) continue;
      if (std::isinf(value)) throw Error({file_, 0, 0}, name, "not a finite number", shortest(value), "");
      values[place] = values_[place] = value;
    }
    return true;
  }

  int line() const override { return number_; }
  Place place(std::size_t) const override { return {file_ + ' ' + stream_, 0, 0}; }
  std::string text(std::size_t chosen) const override { return shortest(values_[chosen]); }
  DecimalText written(std::size_t) const override { return unrounded; }
  DecimalText written_time() const override { return {9, 9, 19}; }
  std::uint64_t size() const override { return size_of_bag(file_); }
  std::uint64_t position() const override { return bag_ ? bag_->position() : 0; }
  std::vector<std::string> first_texts(std::size_t signal) const override {
    return signal == 0 ? std::vector<std::string>{} : found_.texts[signal - 1];
  }
  std::vector<std::string> warnings() const override {
    std::vector<std::string> all = warnings_;
    if (!uses_header() && !chosen_.empty())
      all.push_back(name() + ": its messages have no stamps; those of the recorder are used");
    return all;
  }

 private:
  static constexpr DecimalText unrounded{17, 17, 17};  // doubles, to their last bit

  bool uses_header() const { return found_.stamped == found_.samples; }

  std::string stream_;
  BagStream found_;
  std::vector<std::string> warnings_;
  LogClock& clock_;
  std::map<std::string, std::size_t> index_;
  std::vector<std::ptrdiff_t> places_;
  std::vector<double> values_;
  std::unique_ptr<BagFile> bag_;
  BagMessage message_;
  std::vector<BagSample> samples_;
  std::size_t at_ = 0;
  int number_ = 0;
  std::optional<double> last_;
};

/// What a first pass over a bag finds.
struct BagContents {
  std::vector<std::string> order;  // of the streams, as they begin
  std::map<std::string, BagStream> streams;
  std::map<std::string, std::string> others;  // topics that are not decoded, and their types
  bool cut_off = false;
};

void add_sample(const BagSample& sample, const BagMessage& message, BagContents& found) {
  const auto [at, is_new] = found.streams.try_emplace(sample.stream);
  BagStream& stream = at->second;
  if (is_new) {
    found.order.push_back(sample.stream);
    stream.topic = message.topic;
  }
  ++stream.samples;
  stream.stamped += sample.stamp.has_value();
  for (const auto& [name, value] : sample.values) {
    auto known = std::ranges::find(stream.names, name);
    if (known == stream.names.end()) {
      known = stream.names.insert(known, name);
      stream.texts.emplace_back();
    }
    auto& texts = stream.texts[known - stream.names.begin()];
    if (texts.size() < most_texts) texts.push_back(shortest(value));
  }
}

BagContents contents_of(const std::string& path) {
  BagContents found;
  const auto bag = open_bag(path, "");
  BagMessage message;
  std::vector<BagSample> samples;
  while (bag->next(message)) {
    if (!is_decoded(message.type)) {
      found.others.try_emplace(std::string(message.topic), message.type);
      continue;
    }
    decode_checked(path, message, samples);
    for (const BagSample& sample : samples) add_sample(sample, message, found);
  }
  found.cut_off = bag->is_cut_off();
  return found;
}

}  // namespace

std::vector<std::unique_ptr<LogSamples>> open_bag_log(const std::string& path, const LogReading& reading,
                                                      LogClock& clock) {
  BagContents found = contents_of(path);
  std::string others;
  for (const auto& [topic, type] : found.others)
    if (others.size() < 200) others += (others.empty() ? "" : ", ") + topic + " (" + type + ')';
  if (found.order.empty())
    throw Error({path, 0, 0}, "", "the bag has no topic that is read", others,
                "record JointState, PoseStamped, TransformStamped or Float64");
  std::vector<std::string> warnings;
  if (!others.empty()) warnings.push_back(path + ": topics of other types are not read: " + others);
  if (found.cut_off) warnings.push_back(path + ": ends within a record: the recording was cut off");
  std::vector<std::unique_ptr<LogSamples>> all;
  for (const std::string& stream : found.order) {
    all.push_back(std::make_unique<BagSamples>(path, stream, std::move(found.streams[stream]),
                                               std::exchange(warnings, {}), reading, clock));
  }
  return all;
}

}  // namespace qerr
