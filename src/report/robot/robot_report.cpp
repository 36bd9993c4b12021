#include "qerr/report/robot_report.hpp"

#include "core/sha256.hpp"
#include "kinematics/tree.hpp"
#include "qerr/input/first_spec.hpp"

namespace qerr {

RobotReport robot_report(RobotModel robot, const std::string& text, const std::string& base,
                         const std::string& tip) {
  RobotReport report;
  report.robot = std::move(robot);
  report.sha256 = sha256(text);
  report.roots = Tree(report.robot).roots();
  report.ends = tree_ends(report.robot, base);
  try {
    const Chain chain = first_chain(report.robot, base, tip);
    report.base = chain.base;
    report.tip = chain.tip;
  } catch (const Error& e) {
    if (!base.empty() || !tip.empty()) throw;
    report.obstacle = e.what();
  }
  return report;
}

}  // namespace qerr
