#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace qerr {

/// A message of a bag, as recorded.
struct BagMessage {
  std::string_view topic, type;  ///< `sensor_msgs/msg/JointState`
  std::string_view data;
  std::int64_t received = 0;  ///< [ns]
  bool ros1 = false;          ///< in the encoding of ROS 1; else CDR
};

/// Values of one instant in a message.
struct BagSample {
  std::string stream;  ///< of samples that follow each other: the topic, the child frame of a transform, ...
  std::optional<std::int64_t> stamp;  ///< of the header [ns]; empty: the message has none, or zero
  std::vector<std::pair<std::string, double>> values;  ///< `/joint_states/elbow/position`
};

/// Whether messages of a type are decoded: JointState, poses, points, transforms, single numbers.
bool is_decoded(std::string_view type);

/// Decodes a message; names are those that PlotJuggler gives: `TOPIC/JOINT/position`,
/// `TOPIC/pose/position/x`, `TOPIC/CHILD_FRAME/translation/x`, `TOPIC/data`.
/// @throws std::range_error for one that ends too early
void decode_message(const BagMessage&, std::vector<BagSample>&);

}  // namespace qerr
