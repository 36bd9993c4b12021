#pragma once

#include <memory>
#include <string>
#include <vector>

#include "input/object_reader.hpp"
#include "input/override.hpp"
#include "qerr/input/first_spec.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// Reads the tree of a spec into a Spec, and then trees in which few sections differ.
///
/// A copy shares the robot. Reading again does not change the reader.
class SpecReader {
 public:
  /// @param path  of the spec, to which its own paths are relative
  explicit SpecReader(const std::string& path);

  /// @throws Error (input) with all faults; (file_system) if a file cannot be read
  Spec read(const Node& root);

  /// Reads the robot of a spec's tree, and nothing else of it.
  /// @throws Error (input)
  RobotOfSpec robot_of(const Node& root);

  /// Reads the robot of a spec's tree, for changes by joints. Borrows the reader.
  ChainOf chain_of();

  /// The spec of a tree that differs from the one that was read. Only the changed sections and those that
  /// refer to them are read.
  /// @param root     need only have the sections for which `reads_again` is true
  /// @param changed  names of sections of the top level
  /// @pre `read` has succeeded, and the robot is the same
  Spec reread(const Node& root, const std::vector<std::string>& changed) const;

  /// Whether `reread` needs a section.
  static bool reads_again(const std::string& section, const std::vector<std::string>& changed);

  /// Whether a section can change without the robot or the format: else the whole spec must be read.
  static bool can_change(const std::string& section);

 private:
  struct Stage;
  static const std::vector<Stage>& stages();  // in the order of reading
  static bool reads_again(const Stage&, const std::vector<std::string>& changed);

  Object checked_top(const Node& root);
  void read_chain(const Field&);
  void read_tips(const Object& robot);
  std::string find_urdf(const Field& urdf, const std::string& given) const;
  void run(const Stage&, const Object& top, std::size_t index);
  Spec finished() const;

  std::string folder_;
  std::shared_ptr<const RobotModel> robot_;
  std::optional<Coordinate> joint_coordinate_;      ///< of a robot of one joint without radius, by default
  Spec spec_;                                       // without warnings
  std::vector<std::vector<std::string>> warnings_;  // of the robot, and of each stage
  Faults faults_;
  Node known_;  // the sections of a spec that has others, too
};

}  // namespace qerr
