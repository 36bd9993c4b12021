#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "input/urdf_outline.hpp"
#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

std::string_view joint_type_name(JointType type);

inline bool has_axis(JointType type) { return type != JointType::fixed && type != JointType::floating; }
inline bool has_range(JointType type) { return type == JointType::revolute || type == JointType::prismatic; }
inline bool has_one_coordinate(JointType type) { return has_range(type) || type == JointType::continuous; }

/// A joint of the URDF with its angles and its element, which must outlive it.
struct WrittenJoint {
  Joint joint;
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();
  const UrdfElement* element = nullptr;
};

/// Converts the outline into a model and checks every number and every rule of the kinematic tree.
class UrdfReader {
 public:
  explicit UrdfReader(const std::string& file) : file_(file), faults_(file) {}
  RobotModel model;
  std::vector<WrittenJoint> written;

  void read(const UrdfElement& root) {
    read_robot(root);
    for (const UrdfElement& child : root.children) {
      if (child.name == "link") read_link(child);
      if (child.name == "joint") read_joint(child);
    }
    if (model.links.empty()) fault(root, root.title(), "a robot must have at least one link", "", "");
    for (const WrittenJoint& w : written) check_ends(w);
    faults_.raise();  // further faults would be consequences of these
    check_tree(root);
    check_mimics();
    faults_.raise();
  }

 private:
  template <class Located>
  void fault(const Located& at, const std::string& key, std::string rule, std::string found,
             std::string remedy) {
    faults_.add(at.line, at.column, key, std::move(rule), std::move(found), std::move(remedy));
  }
  void warn(const UrdfElement& at, const std::string& key, const std::string& text) {
    model.warnings.push_back(format({Fault{{file_, at.line, at.column}, key, text, "", ""}}));
  }

  void read_robot(const UrdfElement& root);
  void read_link(const UrdfElement& element);
  void read_joint(const UrdfElement& element);
  void read_origin(const UrdfElement& owner, const std::string& key, Eigen::Vector3d& xyz,
                   Eigen::Vector3d& rpy);
  void read_axis(const UrdfElement& element, Joint& joint);
  void read_limit(const UrdfElement& element, Joint& joint);
  void read_mimic(const UrdfElement& element, Joint& joint);
  std::string name_of(const UrdfElement& element, std::unordered_map<std::string, std::size_t>& taken,
                      std::size_t index);
  std::string text_of(const UrdfElement* element, const char* tag, const char* attribute,
                      const UrdfElement& owner);
  template <std::size_t N>
  std::optional<std::array<double, N>> numbers(const UrdfElement& element, const char* name,
                                               const std::string& key);
  std::optional<double> number(const UrdfElement& element, const char* name, const std::string& key);
  void check_ends(const WrittenJoint& w);
  void check_tree(const UrdfElement& root);
  void check_mimics();

  std::string file_;
  FaultList faults_;
  std::unordered_map<std::string, std::size_t> link_index_, joint_index_,
      parent_joint_;  ///< parent_joint_: child link -> its joint
};

}  // namespace qerr
