#include "input/bag_messages.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>

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
    if (big_ != (std::endian::native == std::endian::big)) std::reverse(bytes.begin(), bytes.end());
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
  for (const MessageType& t : message_types)
    if (t.name == plain) return &t;
  return nullptr;
}

}  // namespace

bool is_decoded(std::string_view type) { return find_type(type) != nullptr; }

void decode_message(const BagMessage& message, std::vector<BagSample>& samples) {
  samples.clear();
  FieldReader in(message.data, message.ros1);
  if (const MessageType* type = find_type(message.type))
    type->decode(in, std::string(message.topic), samples);
}

}  // namespace qerr
