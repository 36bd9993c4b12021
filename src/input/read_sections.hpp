#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "input/object_reader.hpp"
#include "input/yaml_tree.hpp"
#include "qerr/core/parameter.hpp"
#include "qerr/input/first_spec.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/kinematics/chain.hpp"
#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

/// The rows of every section of the spec that is not a family. The strict reader and the JSON Schema use the
/// same rows, so that keys, kinds, ranges and defaults agree.
namespace spec_format {

extern const std::vector<Parameter> top;
extern const std::vector<Parameter> robot;
extern const std::vector<Parameter> pose;
extern const std::vector<Parameter> joint;
extern const std::vector<Parameter> dh_row;
const std::vector<Parameter>& filter();
extern const std::vector<Parameter> lowpass;  ///< without the family's own parameters
extern const std::vector<Parameter> configurations;
const std::vector<Parameter>& requirement();
extern const std::vector<Parameter> threshold;
extern const std::vector<Parameter> motion;
extern const std::vector<Parameter> joint_motion;
extern const std::vector<Parameter> sine;
extern const std::vector<Parameter> move;
extern const std::vector<Parameter> effect;  ///< without the effect's own parameters
extern const std::vector<Parameter> control;
extern const std::vector<Parameter> controller;  ///< of a joint
extern const std::vector<Parameter> tip_impedance;
extern const std::vector<Parameter> estimator;
extern const std::vector<Parameter> wall;
extern const std::vector<Parameter> log;
extern const std::vector<Parameter> log_column;
extern const std::vector<Parameter> sweep;
extern const std::vector<Parameter> design;
extern const std::vector<Parameter> design_filter;
extern const std::vector<Parameter> design_gains;
extern const std::vector<Parameter> design_tracking;

/// The keys whose values are paths of files, relative to the spec. `*` is any key, `[]` any item of a list.
const std::vector<std::string_view>& file_keys();
/// Whether a key is one of them, or a section that has one.
bool may_name_a_file(std::string_view key);

/// The dimension of the number at a dotted path in `filters`, `threshold` or `motion`; empty for other keys,
/// of which it depends on the joint or the effect, or that are no numbers.
std::optional<Dimension> dimension_of(const std::string& path);

}  // namespace spec_format

/// A change of a spec: a dotted path, and its value, whose place is that of the change in messages.
using SpecChange = std::pair<std::string, Node>;

/// The kinematic chain of a spec's tree, to which the entries by joints belong; without joints if the tree
/// has no robot.
using ChainOf = std::function<const Chain&(const Node& root)>;

/// Replaces or adds the values at dotted paths (`filters.velocity.derivative`); items of lists are counted
/// from zero, `requirements.0.at_most` or `requirements[0].at_most`. Where keys contain dots, the longest
/// matching key is used.
///
/// In a mapping by joints (`encoders`, `configurations.limits`, `design.encoders`) a pattern changes every
/// entry that governs a joint which it fits. A joint without an entry of its own, or whose pattern governs
/// others, too, first gets a copy of what holds for it. In an encoder's entry the key of a kind (`bits`)
/// removes those that it excludes (`counts_per_rev`, `decoding`). Patterns come before single joints,
/// whatever their order; a change of a whole mapping keeps its place.
/// @param chain_of  is called when joints are needed, with the robot as it is after the changes
/// @returns warnings: a pattern that is an entry itself has changed others, too
/// @throws Error (input) if a path passes through a single value or beyond the end of a list, would begin
/// a new filter with one of its keys, fits no joint of the chain, or is the entry of a joint outside it
std::vector<std::string> apply_changes(Node& root, const std::vector<SpecChange>&, const ChainOf& chain_of);

/// Whether one of two paths is the other one or lies in it, or both state the resolution of one encoder: the
/// last one would hold.
bool set_one_value(const std::string& one, const std::string& other);

/// The change of a path to the value of a YAML text.
/// @param origin  place of the change in messages, such as `--set KEY`
/// @throws Error (input) if the text is not YAML
SpecChange spec_change(const std::string& path, const std::string& text, const std::string& origin);

/// The changes of --set, in the order of the command line.
std::vector<SpecChange> spec_changes(const std::vector<std::pair<std::string, std::string>>& set);

/// The text of a spec with its overrides and further changes written into it; comments and layout of the rest
/// are kept.
/// @param effects  entries that are added to `effects:`; one of the same type and joint is replaced
/// @param remark   a comment at its end
/// @param target   path at which the text will stand, for its paths
/// @throws Error (input), with the place, if the layout of the text does not allow a change
std::string changed_spec(const Spec&, const std::vector<SpecChange>& changes,
                         const std::vector<Node>& effects, const std::string& remark,
                         const std::string& target);

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

/// The dimension of a joint's coordinate: angle, or length for a prismatic joint.
inline Dimension coordinate_dimension(const IndependentJoint& joint) {
  return joint.prismatic() ? dimension::length : dimension::angle;
}

Error unopened(const Field&, const std::string& path, const Error&);

/// Reads a file that a value of the spec names, relative to the spec's folder.
/// @throws Error of `read`; where the file cannot be opened, with the place of the value
template <class Read>
void read_named_file(const Field& f, const std::string& path, Read read) {
  try {
    read(path);
  } catch (const Error& e) {
    if (e.trouble() != Trouble::file_system) throw;
    throw unopened(f, path, e);
  }
}

void read_encoders(const Field&, const RobotModel&, Spec&, Faults&);
/// Warns of gear ratios that contradict those of the URDF. @pre the encoders are read
void warn_of_stated_ratios(const RobotModel&, Spec&);
void read_coupling(const Field&, Spec&);
/// A robot of one joint without URDF, between the links `base` and `tip`: revolute about z, with the tip at
/// `radius` on x, or prismatic along x.
RobotModel read_joint(const Field&, const std::string& file);
/// A robot of a table of Denavit and Hartenberg, a link a row, between the links `base` and `tip`.
/// @param convention  standard, modified, or empty: standard, with a warning where it looks like the other
RobotModel read_dh(const Field&, const std::string& convention, const std::string& file,
                   std::vector<std::string>& warnings);
/// A pose, {xyz, rpy}.
Eigen::Isometry3d read_pose(const Field&);

/// Roll, pitch and yaw of a rotation R_z(yaw) R_y(pitch) R_x(roll); at the gimbal lock roll is 0.
Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d&);
/// The remedy of a coordinate without its tip. @pre the model has several tips
std::string of_which_tip(const OperationalModel&, const std::string& coordinate);
/// Adds a length, and those of its components that are missing.
void add_length(Coordinate, OperationalModel&);
/// Adds a signal that is no coordinate of the tip.
void add_signal(const Signal&, OperationalModel&);
/// Adds x, y and z of each tip of several, as coordinates by default.
void add_positions_of_tips(OperationalModel&);
void read_coordinates(const Field&, Spec&);
void read_filters(const Field&, const RobotModel&, Spec&, Faults&);
/// The norms of a filter.
/// @throws Error (input) without a place if they exceed the range of double, or it passes nothing
Norms checked_norms(const Filter&);
/// @pre filters are read
void read_estimators(const Field&, const RobotModel&, Spec&, Faults&);
/// @pre filters are read
void read_control(const Field&, const RobotModel&, Spec&);
/// The controllers with the velocity filters of a list; null without controllers.
std::shared_ptr<const Control> with_velocity_filters(const std::shared_ptr<const Control>&,
                                                     const std::vector<NamedFilter>&);
void update_controllers(const Control&, std::vector<NamedFilter>&);
/// @pre control is read
void read_walls(const Field&, Spec&, Faults&);
/// Adds the coordinates of joints that have filters or controllers of their own, and the signals of loops.
void add_signals_of_joints(Spec&);
/// What the effects of the encoders make of the loops' readings. @pre control and effects have been read
void add_loop_readings(const Field&, Spec&);
/// @param field  its node is null if the section is absent; the defaults are then checked
void read_configurations(const Field&, const std::string& folder, const RobotModel&, Spec&, Faults&);
void read_requirements(const Field&, Spec&, Faults&);
void read_threshold(const Field&, Spec&);
void read_log_section(const Field&, Spec&);
void read_motion(const Field&, const std::string& folder, const RobotModel&, Spec&, Faults&);
void read_effects(const Field&, const RobotModel&, Spec&, Faults&);
void read_sweep(const Field&, Spec&, Faults&);
/// @pre filters and requirements are read
void read_design(const Field&, const std::string& folder, const RobotModel&, Spec&, Faults&);

/// Limits of the command line, `position.xyz.worst_case=50 um`: bounds of coordinates and their highest
/// values. Lengths that the spec does not have are added to its coordinates.
/// @param option  that the messages name
/// @throws Error (usage)
std::vector<Requirement> read_limits(const std::string& option, const std::vector<std::string>& texts, Spec&);

/// A file with one column per independent joint, in SI units: whatever a log can be (`LogReader`), a bag,
/// too. Its columns are called `JOINT [unit]` or like a signal of a log, or the spec's section `log` names
/// them.
struct JointTable {
  std::string path;
  std::vector<double> time;                           ///< `time [s]`; empty without TimeColumn::required
  Eigen::MatrixXd positions;                          ///< independent joints x rows [rad or m]
  std::vector<RecordedSignal> efforts, temperatures;  ///< of every independent joint, with a time alone
  std::vector<int> lines;                             ///< line of each row, from 1
};

/// Whether a table must have a `time` column that increases.
enum class TimeColumn { none, required };

/// Columns that are not joints of the chain are ignored with a warning. With a time, a joint without a column
/// rests at 0, as in `motion.joints`, and a warning says so, unless there are columns of other names.
/// @throws Error (input) with the place of a missing or duplicate column, a wrong unit, or time that does not
/// increase
JointTable read_joint_table(const std::string& path, const Spec&, TimeColumn,
                            std::vector<std::string>& warnings);

std::string text_of(const Limits&, const IndependentJoint&);

/// Whether the value is within the limits up to a relative 1e-9, which covers limits printed with rounded
/// decimals.
bool inside(double value, const Limits&);

}  // namespace qerr
