#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/robot/parts.hpp"

namespace qerr {

std::string to_csv(const RobotReport& report, const Style&) {
  std::string out =
      "joint,type,parent,child,axis_x,axis_y,axis_z,unit,lower,upper,effort,velocity,ratio,mimic,multiplier,"
      "offset\r\n";
  for (const Joint& joint : report.robot.joints) {
    if (joint.type == JointType::fixed) continue;
    const Json json = json_of(joint);
    out += csv_cells(json, {"name", "type", "parent", "child"});
    for (const double component : joint.axis) out += ',' + shortest(component);
    out += ',' +
           csv_cells(json, {"unit", "limits.lower", "limits.upper", "effort", "velocity", "ratio",
                            "mimic.joint", "mimic.multiplier", "mimic.offset"}) +
           "\r\n";
  }
  return out;
}

}  // namespace qerr
