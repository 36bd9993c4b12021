#include "input/urdf_reader.hpp"
#include "report/csv_text.hpp"
#include "report/formats.hpp"

namespace qerr {

namespace {

std::string cell(const std::optional<double>& value) { return value ? shortest(*value) : ""; }

}  // namespace

std::string to_csv(const RobotReport& report, const Style&) {
  std::string out =
      "joint,type,parent,child,axis_x,axis_y,axis_z,unit,lower,upper,effort,velocity,ratio,mimic,multiplier,"
      "offset\r\n";
  for (const Joint& joint : report.robot.joints) {
    if (joint.type == JointType::fixed) continue;
    out += csv_cell(joint.name) + ',' + std::string(joint_type_name(joint.type)) + ',' +
           csv_cell(joint.parent) + ',' + csv_cell(joint.child) + ',' + shortest(joint.axis.x()) + ',' +
           shortest(joint.axis.y()) + ',' + shortest(joint.axis.z()) + ',' +
           (joint.type == JointType::prismatic ? "m" : "rad") + ',' +
           (joint.limits ? shortest(joint.limits->lower) : "") + ',' +
           (joint.limits ? shortest(joint.limits->upper) : "") + ',' + cell(joint.effort_limit) + ',' +
           cell(joint.velocity_limit) + ',' + cell(joint.stated_ratio) + ',' +
           (joint.mimic ? csv_cell(joint.mimic->joint) + ',' + shortest(joint.mimic->multiplier) + ',' +
                              shortest(joint.mimic->offset)
                        : ",,") +
           "\r\n";
  }
  return out;
}

}  // namespace qerr
