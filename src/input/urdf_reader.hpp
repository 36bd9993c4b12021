#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/lists.hpp"
#include "qerr/core/error.hpp"
#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

struct UrdfAttribute {
  std::string name, value;
  int line = 0, column = 0;
};

/// An element of a URDF; at most 256 levels deep, so that recursion is safe.
struct UrdfElement {
  std::string name;
  int line = 0, column = 0;
  std::vector<UrdfAttribute> attributes;
  std::vector<UrdfElement> children;
  std::string text = {};  ///< between the tags; of transmissions only

  const UrdfAttribute* attribute(std::string_view wanted) const;
  const UrdfElement* child(std::string_view wanted) const;
  /// The name used in messages: `joint 'elbow'`, or `joint` if it has no name.
  std::string title() const;
};

/// The `<robot>` with its links, inertials, joints and the children of joints, and with its transmissions
/// wholly; other elements are skipped.
///
/// Read by expat, because urdfdom reports neither lines nor columns, and silently skips misspelt elements and
/// attributes.
/// @throws Error (input) with line and column for malformed XML, a DTD, extreme depth or size, and another
/// kind of document (SDF, unexpanded xacro)
UrdfElement urdf_outline(const std::string& text, const std::string& file);

/// The flaws of one document, each with the part of the robot that it concerns.
class FlawList {
 public:
  explicit FlawList(std::string file) : file_(std::move(file)) {}

  /// Further flaws concern this child of `<robot>`: a joint, a link, or the document for any other element.
  void concern(const UrdfElement& element);
  /// Further flaws concern the joint of this name.
  void concern_joint(const std::string& name) { concern_joints({name}); }
  void concern_joints(std::vector<std::string> names) {
    part_ = Flaw{.fault = {}, .joints = std::move(names)};
  }
  void concern_document() { part_ = {}; }

  /// A flaw after which the part cannot be used.
  /// @throws Error with all of them when they are very many
  template <class Located>
  Flaw& spoil(const Located& at, std::string key, std::string rule, std::string found, std::string remedy) {
    return add(
        true,
        {{file_, at.line, at.column}, std::move(key), std::move(rule), std::move(found), std::move(remedy)});
  }

  /// A flaw that no figure depends on.
  template <class Located>
  void warn(const Located& at, std::string key, std::string rule, std::string found = {},
            std::string remedy = {}) {
    add(false,
        {{file_, at.line, at.column}, std::move(key), std::move(rule), std::move(found), std::move(remedy)});
  }

  void raise() const;  ///< @throws Error with the flaws that spoil a part, if there is any
  std::vector<Flaw> take() { return std::move(flaws_); }

 private:
  Flaw& add(bool spoils, Fault fault);

  std::string file_;
  Flaw part_;
  std::vector<Flaw> flaws_;
  std::size_t spoiling_ = 0;
};

/// Allowed contents of an element: `many` and `once` are read, `whole` is kept with all that it contains,
/// `ignored` is skipped. Any other name is foreign (a tag of a simulator) unless it resembles a known one.
struct Vocabulary {
  using Names = std::vector<std::string>;
  std::string_view element;
  Names many, once, whole, ignored, attributes;

  static bool has(const Names& names, std::string_view name) { return contains(names, name); }
};

/// The row of an element; null if the element has none.
const Vocabulary* vocabulary(std::string_view element);

std::string_view joint_type_name(JointType type);

inline bool has_axis(JointType type) { return type != JointType::fixed && type != JointType::floating; }
inline bool has_range(JointType type) { return type == JointType::revolute || type == JointType::prismatic; }
inline bool has_one_coordinate(JointType type) { return has_range(type) || type == JointType::continuous; }

/// Endings of the names of the joints that a planar joint is split into.
inline constexpr std::array planar_coordinates{"/x", "/y", "/yaw"};

/// A joint of the URDF with its angles and its element, which must outlive it.
struct WrittenJoint {
  Joint joint;
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();
  const UrdfElement* element = nullptr;
  bool in_tree = true;  ///< false: a flaw excludes it
};

/// `gear_ratio 50 and -50, coupling [[0.5, 0.5], [0.25, -0.25]]`.
std::string coupling_text(const std::array<double, 2>& ratios, const Eigen::Matrix2d& coupling);

/// Travel of a prismatic joint per motor revolution, 2 pi / |ratio| [m]; empty for other joints, without a
/// ratio, and where it exceeds the joint's range or 0.5 m: the ratio is then that of a gear, without the
/// screw's lead.
std::optional<double> stated_travel(const Joint&);

/// Converts the outline into a model and checks every number and every rule of the kinematic tree.
class UrdfReader {
 public:
  explicit UrdfReader(const std::string& file) : file_(file), flaws_(file) {}
  RobotModel model;
  std::vector<WrittenJoint> written;

  /// @throws Error (input) for flaws of the document as a whole; others are left in model.flaws
  void read(const UrdfElement& root);

 private:
  template <class Located>
  Flaw& spoil(const Located& at, const std::string& key, std::string rule, std::string found,
              std::string remedy) {
    return flaws_.spoil(at, key, std::move(rule), std::move(found), std::move(remedy));
  }
  [[noreturn]] void refuse(const UrdfElement& root, std::string rule, std::string found, std::string remedy);

  void read_robot(const UrdfElement& root);
  void read_link(const UrdfElement& element);
  void read_joint(const UrdfElement& element);
  void read_origin(const UrdfElement& owner, const std::string& key, Eigen::Vector3d& xyz,
                   Eigen::Vector3d& rpy);
  void read_axis(const UrdfElement& element, Joint& joint);
  void read_limit(const UrdfElement& element, Joint& joint);
  std::optional<double> read_bound(const UrdfElement& limit, const char* name, const Joint& joint);
  std::optional<double> read_strength(const UrdfElement& limit, const char* name, const Joint& joint);
  void read_mimic(const UrdfElement& element, Joint& joint);
  using Reductions = std::map<std::string, std::vector<const UrdfElement*>>;  ///< by joint
  void read_ratios(const UrdfElement& root);
  void warn_of_transmissions_inside(const UrdfElement& gazebo);
  void warn_of_unused_ratios(const Reductions& stated);
  void read_transmission(const UrdfElement& element, bool ros2, Reductions& stated);
  const UrdfElement* only_reduction(const std::vector<const UrdfElement*>& owners, const std::string& joint);
  std::string read_coupling(const std::string& type, const UrdfElement& transmission);
  std::string obstacle_to_coupling(const StatedCoupling&) const;
  void warn_of_foreign_joint(const UrdfElement& transmission, const std::vector<const UrdfElement*>& joints);
  void settle_ratio(Joint& joint, const std::vector<const UrdfElement*>& stated);
  std::string name_of(const UrdfElement& element);
  std::string text_of(const UrdfElement* element, const char* tag, const char* attribute,
                      const UrdfElement& owner);
  template <std::size_t N>
  std::optional<std::array<double, N>> numbers(const UrdfElement& element, const char* name,
                                               const std::string& key);
  std::optional<double> number(const UrdfElement& element, const char* name, const std::string& key);
  void check_ends(WrittenJoint& w);
  void check_tree(const UrdfElement& root);
  void check_roots(const UrdfElement& root);
  void check_mimics();
  void check_mimic_loops();
  void drop_mimic(WrittenJoint& w, std::string rule, std::string found, std::string remedy);

  std::string file_;
  FlawList flaws_;
  std::unordered_map<std::string, std::size_t> link_index_, joint_index_,
      parent_joint_;                           ///< parent_joint_: child link -> its joint
  std::map<std::string, std::string> motors_;  ///< of transmissions of one joint: name, joint
};

/// The file that `robot.urdf` names: a path relative to the folder of the spec, or `package://PKG/PATH`,
/// looked up in the ROS packages of AMENT_PREFIX_PATH (`share/PKG`) and ROS_PACKAGE_PATH, or `file://PATH`.
/// @throws Error (input, without a place) for an unknown scheme or a package that is not found
std::string urdf_path(const std::string& given, const std::string& folder);

}  // namespace qerr
