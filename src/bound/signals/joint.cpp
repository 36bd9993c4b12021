#include "bound/signals/signals.hpp"
#include "qerr/bound/operational_error.hpp"

namespace qerr {

namespace {

/// `joint:NAME` of a joint that is called like a coordinate.
std::vector<Signal> of_joints(const OperationalModel& model) {
  std::vector<Signal> signals;
  for (const IndependentJoint& joint : model.chain.independent)
    signals.push_back(
        {(find_coordinate(joint.name) || joint.name == "joints" ? "joint:" : "") + joint.name, joint.unit()});
  return signals;
}

}  // namespace

/// The coordinate of an independent joint, behind gears and coupling.
SignalKind joint_signal() {
  return {
      .group = "joints",
      .summary = "the robot's joints; a joint's name, or joint:NAME, is one of them",
      .signals = of_joints,
      .row =
          [](const OperationalModel& model, std::size_t index, const Eigen::VectorXd&) {
            return Eigen::RowVectorXd(Eigen::RowVectorXd::Unit(std::ssize(model.chain.independent), index));
          },
      .remainder = [](const OperationalModel&, std::size_t, const Eigen::VectorXd&,
                      const Eigen::VectorXd&) { return 0.0; },
      .constant = true,
      .joints = true};
}

}  // namespace qerr
