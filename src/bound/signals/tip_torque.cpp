#include <limits>

#include "bound/signals/signals.hpp"
#include "control/control.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {

namespace {

std::vector<Signal> torques(const OperationalModel& m) {
  std::vector<Signal> signals;
  if (!m.control || !m.control->tip) return signals;
  for (const IndependentJoint& joint : m.chain.independent)
    signals.push_back({"torque." + joint.name, joint.effort_unit()});
  return signals;
}

/// An error e moves joint i's torque by (J^T K J C)_ie + (J^T D J C)_ie H_v: one filter, whose norms follow
/// from those of H_v, as only its first sample has both.
SignalNorms norms_at(const OperationalModel& m, std::size_t index, const Eigen::VectorXd& q,
                     const Eigen::MatrixXd& moved, const LoopsAt&) {
  const TipImpedance& tip = *m.control->tip;
  const Eigen::MatrixXd rows = jacobian(m.chain, q).topRows<3>();
  const Eigen::RowVectorXd own = rows.col(index).transpose();
  const Eigen::RowVectorXd k = own * tip.stiffness.asDiagonal() * rows * moved,
                           d = own * tip.damping.asDiagonal() * rows * moved;
  SignalNorms n{k, k, k + d * tip.velocity_sums.dc};
  for (Eigen::Index e = 0; e < k.size(); ++e) {
    n.l1[e] = tip.velocity_sums.l1(k[e], d[e]);
    n.h2[e] = tip.velocity_sums.h2(k[e], d[e]);
  }
  return n;
}

}  // namespace

/// The torque of each joint due to errors, of an impedance at the tip, at a constant Jacobian.
SignalKind tip_torque_signal() {
  return {.group = "torque",
          .summary = "torque of each joint by the impedance at the tip of `control:`, torque.JOINT",
          .signals = torques,
          .row =
              [](const OperationalModel&, std::size_t index, const Eigen::VectorXd& q) {
                return Eigen::RowVectorXd(Eigen::RowVectorXd::Unit(q.size(), index));
              },
          .remainder = [](const OperationalModel&, std::size_t, const Eigen::VectorXd&,
                          const Eigen::VectorXd&) { return std::numeric_limits<double>::infinity(); },
          .norms = norms_at};
}

}  // namespace qerr
