#include "input/urdf_reader.hpp"
#include "report/formats.hpp"
#include "report/json_value.hpp"

namespace qerr {

namespace {

Json joint_json(const Joint& joint) {
  const bool linear = joint.type == JointType::prismatic;
  Json j = {{"name", joint.name},
            {"type", joint_type_name(joint.type)},
            {"parent", joint.parent},
            {"child", joint.child}};
  if (joint.type == JointType::fixed) return j;
  j["unit"] = linear ? "m" : "rad";
  j["axis"] = Json::array({joint.axis.x(), joint.axis.y(), joint.axis.z()});
  j["limits"] = joint.limits ? Json{{"lower", joint.limits->lower}, {"upper", joint.limits->upper}} : Json();
  j["effort"] = joint.effort_limit;
  j["velocity"] = joint.velocity_limit;
  j["ratio"] = joint.stated_ratio;
  j["mimic"] = joint.mimic ? Json{{"joint", joint.mimic->joint},
                                  {"multiplier", joint.mimic->multiplier},
                                  {"offset", joint.mimic->offset}}
                           : Json();
  return j;
}

}  // namespace

std::string to_json(const RobotReport& report, const Style&) {
  const RobotModel& robot = report.robot;
  Json joints = Json::array(), ends = Json::array(), flaws = Json::array();
  for (const Joint& joint : robot.joints) joints.push_back(joint_json(joint));
  Json couplings = Json::array();
  for (const StatedCoupling& c : robot.couplings)
    couplings.push_back({{"transmission", c.transmission},
                         {"type", c.type},
                         {"joints", Json::array({c.joints[0], c.joints[1]})},
                         {"ratios", Json::array({c.ratios[0], c.ratios[1]})},
                         {"coupling", Json::array({Json::array({c.coupling(0, 0), c.coupling(0, 1)}),
                                                   Json::array({c.coupling(1, 0), c.coupling(1, 1)})})}});
  for (const TreeEnd& end : report.ends) {
    Json names = Json::array();
    for (const std::size_t i : end.joints) names.push_back(robot.joints[i].name);
    ends.push_back({{"tip", end.tip},
                    {"base", end.base},
                    {"moving_joints", end.joints.size()},
                    {"kind", end_kind_name(end.kind)},
                    {"joints", names}});
  }
  for (const Flaw& flaw : robot.flaws)
    flaws.push_back({{"severity", flaw.spoils ? "error" : "warning"}, {"message", format({flaw.fault})}});
  Json first = Json();
  if (!report.tip.empty()) first = {{"base", report.base}, {"tip", report.tip}};
  return Json{{"qerr", version()},
              {"command", "robot"},
              {"urdf", {{"file", robot.file}, {"sha256", report.sha256}}},
              {"robot", {{"name", robot.name}, {"roots", report.roots}}},
              {"first_spec", first},
              {"links", robot.links},
              {"joints", joints},
              {"couplings", couplings},
              {"ends", ends},
              {"flaws", flaws}}
      .document();
}

}  // namespace qerr
