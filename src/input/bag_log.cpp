#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "core/text.hpp"
#include "input/bag_file.hpp"
#include "input/log_samples.hpp"

namespace qerr {

namespace {

constexpr std::size_t most_texts = 1000;  // kept of each signal, for a proposal of the mapping

/// The signals of samples that follow each other: a topic, or a part of it.
struct BagStream {
  std::string topic;
  std::vector<std::string> names;
  std::vector<std::vector<std::string>> texts;  // of the first values
  std::uint64_t samples = 0, stamped = 0;       // with a stamp in the header
};

[[noreturn]] void refuse_message(const std::string& file, const BagMessage& message, const char* why) {
  throw Error({{file, 0, 0},
               std::string(message.topic),
               "a message of " + std::string(message.type) + " is damaged: " + why,
               "",
               ""});
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
      : path_(path),
        stream_(std::move(stream)),
        found_(std::move(found)),
        warnings_(std::move(warnings)),
        clock_(clock) {
    signals_.push_back({"time [s]", {path_, 0, 0}, {"time", "s", false}});
    const std::vector<ColumnMeaning> meanings = column_meanings(found_.names, reading);
    for (std::size_t i = 0; i < found_.names.size(); ++i) {
      signals_.push_back({found_.names[i], {path_, 0, 0}, meanings[i]});
      index_[found_.names[i]] = i + 1;
    }
  }

  const std::vector<LogHeader>& signals() const override { return signals_; }
  std::optional<std::size_t> time() const override { return 0; }
  std::string name() const override { return path_ + ' ' + stream_; }

  void choose(const std::vector<std::size_t>& signals) override {
    chosen_ = signals;
    places_.assign(signals_.size(), -1);
    for (std::size_t i = 0; i < signals.size(); ++i) places_[signals[i]] = static_cast<std::ptrdiff_t>(i);
    values_.assign(signals.size(), std::nan(""));
    if (!signals.empty()) bag_ = open_bag(path_, found_.topic);
  }

  bool next(double& time, double* values) override {
    while (at_ == samples_.size() || samples_[at_].stream != stream_) {
      if (at_ < samples_.size()) {
        ++at_;
        continue;
      }
      if (!bag_ || !bag_->next(message_)) return false;
      decode_checked(path_, message_, samples_);
      at_ = 0;
    }
    const BagSample& sample = samples_[at_++];
    ++number_;
    time = clock_.seconds(
        stamp_of(uses_header() ? sample.stamp.value_or(message_.received) : message_.received));
    if (last_ && time < *last_)
      throw Error({{path_, 0, 0},
                   stream_,
                   "time must not decrease, after " + shortest(clock_.origin() + *last_) + " s",
                   shortest(clock_.origin() + time),
                   "do two publishers share the topic, or was a simulated clock started again?"});
    last_ = time;
    std::fill_n(values, chosen_.size(), std::nan(""));
    for (const auto& [name, value] : sample.values) {
      const auto found = index_.find(name);
      const std::ptrdiff_t place = found == index_.end() ? -1 : places_[found->second];
      if (place < 0) continue;
      if (std::isinf(value)) throw Error({{path_, 0, 0}, name, "not a finite number", shortest(value), ""});
      values[place] = values_[static_cast<std::size_t>(place)] = value;
    }
    return true;
  }

  int line() const override { return number_; }
  int line_of(std::size_t) const override { return number_; }
  Place place(std::size_t) const override { return {path_ + ' ' + stream_, 0, 0}; }
  std::string text(std::size_t chosen) const override { return shortest(values_[chosen]); }
  DecimalText written(std::size_t) const override { return unrounded; }
  DecimalText written_time() const override { return {9, 9, 19}; }
  std::string file() const override { return path_; }
  std::uint64_t size() const override { return size_of_bag(path_); }
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

  std::string path_, stream_;
  BagStream found_;
  std::vector<std::string> warnings_;
  LogClock& clock_;
  std::vector<LogHeader> signals_;
  std::map<std::string, std::size_t> index_;
  std::vector<std::size_t> chosen_;
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
    auto known = std::find(stream.names.begin(), stream.names.end(), name);
    if (known == stream.names.end()) {
      known = stream.names.insert(known, name);
      stream.texts.emplace_back();
    }
    auto& texts = stream.texts[static_cast<std::size_t>(known - stream.names.begin())];
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
    throw Error({{path, 0, 0},
                 "",
                 "the bag has no topic that is read",
                 others,
                 "record JointState, PoseStamped, TransformStamped or Float64"});
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
