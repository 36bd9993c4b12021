#include "bound/signals/signals.hpp"

namespace qerr {

/// The torque of a joint in its closed loop, -C/(1 + L) times the error of its reading.
SignalKind closed_torque_signal() {
  return {.group = "closed_torque",
          .summary = "torque of each joint in the closed loop of `control:`, closed_torque.JOINT",
          .signals = [](const OperationalModel& m) { return loop_signals(m, "closed_torque.", true); },
          .row = joint_row,
          .remainder = [](const OperationalModel&, std::size_t, const Eigen::VectorXd&,
                          const Eigen::VectorXd&) { return 0.0; },
          .norms =
              [](const OperationalModel& m, std::size_t index, const Eigen::VectorXd& q,
                 const Eigen::MatrixXd& moved, const LoopsAt& loops) {
                return norms_in_loops(m, joint_row(m, index, q), moved, loops, true);
              }};
}

}  // namespace qerr
