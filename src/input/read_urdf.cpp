#include <console_bridge/console.h>
#include <unistd.h>
#include <urdf_parser/urdf_parser.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <new>
#include <sstream>
#include <unordered_map>
#include <utility>

#include "core/solve.hpp"
#include "core/text.hpp"
#include "input/csv.hpp"
#include "input/urdf_reader.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/input/first_spec.hpp"

// A URDF is read in three steps: expat gives the outline with lines and columns (urdf_outline), UrdfReader
// checks names, numbers and tree with messages at these places (urdf_reader, urdf_tree), and urdfdom reads
// the kinematic part of the checked document; the model is made from what urdfdom returns. The first two
// steps are necessary since urdfdom reports no places and silently skips misspelt elements and attributes.
namespace qerr {

namespace {

std::string attribute(const char* name, const std::string& value) {
  return std::string(" ") + name + "=\"" + value + '"';
}

std::string triple(const Eigen::Vector3d& v) {
  return shortest(v.x()) + ' ' + shortest(v.y()) + ' ' + shortest(v.z());
}

std::string numbered(char letter, std::size_t index) { return letter + std::to_string(index); }

/// The checked robot as a URDF for urdfdom: with all limits, which it requires, and without what can make it
/// fail: shapes, foreign tags, names (numbers replace them), and a second root (one link joins all).
std::string sanitized(const RobotModel& model, const std::vector<WrittenJoint>& written) {
  std::unordered_map<std::string, std::size_t> link, joint;
  for (std::size_t i = 0; i < model.links.size(); ++i) link.emplace(model.links[i], i);
  for (std::size_t i = 0; i < written.size(); ++i) joint.emplace(written[i].joint.name, i);
  std::vector<bool> is_root(model.links.size(), true);
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<robot name=\"r\">\n<link name=\"root\"/>\n";
  for (std::size_t i = 0; i < model.links.size(); ++i)
    xml += "<link" + attribute("name", numbered('l', i)) + "/>\n";
  for (std::size_t i = 0; i < written.size(); ++i) {
    const WrittenJoint& w = written[i];
    if (!w.in_tree) continue;
    is_root[link.at(w.joint.child)] = false;
    xml += "<joint" + attribute("name", numbered('j', i)) +
           attribute("type", std::string(joint_type_name(w.joint.type))) + "><origin" +
           attribute("xyz", triple(w.joint.origin.translation())) + attribute("rpy", triple(w.rpy)) +
           "/><parent" + attribute("link", numbered('l', link.at(w.joint.parent))) + "/><child" +
           attribute("link", numbered('l', link.at(w.joint.child))) + "/>";
    if (has_axis(w.joint.type)) xml += "<axis" + attribute("xyz", triple(w.joint.axis)) + "/>";
    const Limits limits = w.joint.limits.value_or(Limits{});
    if (has_range(w.joint.type))
      xml += "<limit" + attribute("lower", shortest(limits.lower)) +
             attribute("upper", shortest(limits.upper)) + " effort=\"0\" velocity=\"0\"/>";
    if (w.joint.mimic)
      xml += "<mimic" + attribute("joint", numbered('j', joint.at(w.joint.mimic->joint))) +
             attribute("multiplier", shortest(w.joint.mimic->multiplier)) +
             attribute("offset", shortest(w.joint.mimic->offset)) + "/>";
    xml += "</joint>\n";
  }
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (is_root[i])
      xml += "<joint" + attribute("name", numbered('r', i)) +
             " type=\"fixed\"><parent link=\"root\"/><child" + attribute("link", numbered('l', i)) +
             "/></joint>\n";
  return xml + "</robot>\n";
}

/// Captures messages that urdfdom would print. Its output handler is global, hence the lock.
class Captured : public console_bridge::OutputHandler {
 public:
  Captured() : lock_(mutex()) { console_bridge::useOutputHandler(this); }
  Captured(const Captured&) = delete;
  Captured& operator=(const Captured&) = delete;
  ~Captured() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_error.empty()) first_error = text;
  }
  std::string first_error;

 private:
  static std::mutex& mutex() {
    static std::mutex one;
    return one;
  }
  std::lock_guard<std::mutex> lock_;
};

/// Destroys a tree of urdfdom without recursion: its links own their children, so that the destructor of a
/// long chain would overflow the stack.
struct Dismantled {
  ::urdf::ModelInterfaceSharedPtr tree;
  ~Dismantled() {
    if (!tree) return;
    for (auto& [name, link] : tree->links_) {
      link->child_links.clear();
      link->child_joints.clear();
    }
  }
};

/// R = Rz(yaw) Ry(pitch) Rx(roll) from the angles, which is more accurate than the quaternion of urdfdom.
Eigen::Matrix3d rotation(const Eigen::Vector3d& rpy) {
  const double cr = std::cos(rpy.x()), sr = std::sin(rpy.x());
  const double cp = std::cos(rpy.y()), sp = std::sin(rpy.y());
  const double cy = std::cos(rpy.z()), sy = std::sin(rpy.z());
  Eigen::Matrix3d r;
  r << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,   //
      -sp, cp * sr, cp * cr;
  return r;
}

Eigen::Vector3d vector(const ::urdf::Vector3& v) { return {v.x, v.y, v.z}; }

/// The joint as read by urdfdom, with its names, its place and the presence of limits from the outline.
Joint joint_from(const ::urdf::Joint& read, const WrittenJoint& w) {
  Joint joint = w.joint;
  joint.origin.translation() = vector(read.parent_to_joint_origin_transform.position);
  joint.origin.linear() = rotation(w.rpy);
  if (has_axis(joint.type)) joint.axis = vector(read.axis).stableNormalized();
  if (joint.limits) joint.limits = Limits{read.limits->lower, read.limits->upper};
  if (joint.mimic) joint.mimic = Mimic{joint.mimic->joint, read.mimic->multiplier, read.mimic->offset};
  return joint;
}

void take_from_urdfdom(RobotModel& model, const std::vector<WrittenJoint>& written) {
  Captured output;
  Dismantled parsed;
  try {
    parsed.tree = ::urdf::parseURDF(sanitized(model, written));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    output.first_error = e.what();
  }
  // It was given what this reader has accepted: it lacked memory, which it reports in many ways, or one of
  // the two is wrong.
  if (!parsed.tree || !output.first_error.empty())
    throw Error(
        {model.file}, "robot '" + model.name + "'",
        "urdfdom rejects a robot that qerr accepts, perhaps for lack of memory: " + output.first_error, "",
        "", Trouble::internal);
  for (std::size_t i = 0; i < written.size(); ++i) {
    const WrittenJoint& w = written[i];
    if (!w.in_tree) continue;
    const auto read = parsed.tree->joints_.find(numbered('j', i));
    if (read == parsed.tree->joints_.end())
      throw Error(w.joint.place, w.element->title(), "urdfdom does not return this joint", "", "");
    model.joints.push_back(joint_from(*read->second, w));
  }
}

/// Replaces each planar joint by its coordinates: x and y in the plane, which is that of the joint's frame
/// rotated by the least angle that takes z to the normal, and yaw about the normal. Two links without mass
/// are between them.
void split_planar_joints(RobotModel& model) {
  std::vector<Joint> joints;
  std::map<std::string, std::vector<std::string>> parts;
  for (Joint& planar : model.joints) {
    if (planar.type != JointType::planar) {
      joints.push_back(std::move(planar));
      continue;
    }
    const Eigen::Matrix3d in_plane = frame_of_axis(planar.axis);
    std::vector<std::string>& names = parts[planar.name];
    for (int k = 0; k < 3; ++k) {
      Joint& joint = joints.emplace_back(planar);
      joint.name += planar_coordinates[k];
      joint.type = k < 2 ? JointType::prismatic : JointType::continuous;
      if (k < 2) joint.axis = in_plane.col(k);
      joint.velocity_limit = joint.effort_limit = joint.stated_ratio = std::nullopt;
      if (k > 0) joint.origin = Eigen::Isometry3d::Identity(), joint.parent = names.back();
      if (k < 2) {
        joint.child = model.links.emplace_back(joint.name);
        model.inertias.emplace_back();
      }
      names.push_back(joint.name);
    }
  }
  model.joints = std::move(joints);
  for (Flaw& flaw : model.flaws)
    for (const auto& [name, split] : parts)
      if (std::erase(flaw.joints, name) > 0)
        flaw.joints.insert(flaw.joints.end(), split.begin(), split.end());
}

bool is_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (access(((folder.empty() ? "." : folder) + '/' + name).c_str(), X_OK) == 0) return true;
  return false;
}

std::string expanded_template(const std::string& path) {
  std::FILE* pipe = popen(("xacro -- " + shell_word(path)).c_str(), "r");
  std::string text;
  char part[4096];
  for (std::size_t count; pipe && (count = std::fread(part, 1, sizeof part, pipe)) > 0;)
    text.append(part, count);
  if (!pipe || pclose(pipe) != 0)
    throw Error({path}, "", "xacro cannot expand this template", "",
                "see what it says: xacro " + shell_word(path));
  return text;
}

}  // namespace

std::string urdf_text(const std::string& path) {
  std::string text = read_text(path);
  const bool is_template = path != "-" && text.find("<xacro:") != std::string::npos && is_program("xacro");
  return is_template ? expanded_template(path) : text;
}

RobotModel read_urdf(const std::string& path) {
  return parse_urdf(urdf_text(path), path == "-" ? "(standard input)" : path);
}

RobotModel parse_urdf(const std::string& text, const std::string& file) {
  check_text(text, file);
  const UrdfElement root = urdf_outline(text, file);
  UrdfReader reader(file);
  reader.read(root);
  take_from_urdfdom(reader.model, reader.written);
  split_planar_joints(reader.model);
  return std::move(reader.model);
}

}  // namespace qerr
