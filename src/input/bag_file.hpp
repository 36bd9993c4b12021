#pragma once

#include <cstdint>
#include <memory>
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

/// The messages of a recorded bag, one after the other, in memory that does not grow with it: a file of MCAP
/// (mcap.dev; chunks plain or compressed by LZ4 or Zstandard), or rosbag2's database of SQLite.
class BagFile {
 public:
  virtual ~BagFile() = default;

  /// The next message; its texts are valid until the next call. @returns false at the end
  /// @throws Error (input) for a file that is damaged, or in an encoding that is not read
  virtual bool next(BagMessage&) = 0;

  /// Bytes read so far.
  virtual std::uint64_t position() const = 0;
  /// Whether the file ends within a record: the recording was cut off.
  virtual bool is_cut_off() const { return false; }
};

/// Whether a path names a bag: a file that begins like one, the folder that rosbag2 records into, or the
/// `metadata.yaml` in it. A pipe, whose writer would notice the look, is none.
bool is_bag(const std::string& path);

/// Bytes of all files of a bag.
std::uint64_t size_of_bag(const std::string& path);

/// Opens a bag. The files of a recording that was split are one bag, in the order of their numbers.
/// @param topic  of the messages; "" for all
/// @throws Error (file_system) if the file cannot be read; (input) if it is no bag
std::unique_ptr<BagFile> open_bag(const std::string& path, const std::string& topic);

}  // namespace qerr
