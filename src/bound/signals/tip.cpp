#include <array>

#include "bound/signals/signals.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {

namespace {

/// Not roll, pitch and yaw, whose rates are unbounded at the gimbal lock.
constexpr std::array coordinates_of_tips{Coordinate::x,  Coordinate::y,  Coordinate::z,
                                         Coordinate::rx, Coordinate::ry, Coordinate::rz};

std::vector<Signal> coordinates_of_all_tips(const OperationalModel& m) {
  std::vector<Signal> all;
  if (!m.tips) return all;
  for (const NamedTip& tip : *m.tips)
    for (const Coordinate c : coordinates_of_tips)
      all.push_back({tip.name + '.' + std::string(info(c).name), std::string(info(c).unit)});
  return all;
}

ChainCoordinate coordinate_of_tip(const OperationalModel& m, std::size_t index) {
  return {&(*m.tips)[index / coordinates_of_tips.size()].chain,
          coordinates_of_tips[index % coordinates_of_tips.size()]};
}

Eigen::RowVectorXd row_of_tip(const OperationalModel& m, std::size_t index, const Eigen::VectorXd& q) {
  const auto [chain, coordinate] = coordinate_of_tip(m, index);
  Eigen::Isometry3d pose;
  const Jacobian j = joint_jacobian(*chain, q, &pose);
  return to_independent(*chain, coordinate_rows({coordinate}, j, pose.linear(), m.frame));
}

/// As of the only tip (`operational_error`).
double remainder_of_tip(const OperationalModel& m, std::size_t index, const Eigen::VectorXd& q,
                        const Eigen::VectorXd& worst_case) {
  const auto [chain, coordinate] = coordinate_of_tip(m, index);
  const LinearizationRemainder r = linearization_remainder(*chain, worst_case);
  if (!is_position(coordinate)) return r.rotation;
  return r.position + joint_jacobian(*chain, q).topRows<3>().colwise().norm() * r.per_column;
}

}  // namespace

/// Coordinates of the tips of a spec with several, in the axes of the base, and of one tip relative to
/// another, in the axes of the latter: their chain has none of the joints that both have in common.
SignalKind tip_signal() {
  return {.group = "tips",
          .summary = "of `robot.tips`: left.x .. left.rz, and right-left.x, one relative to the other",
          .signals = coordinates_of_all_tips,
          .row = row_of_tip,
          .remainder = remainder_of_tip,
          .of_chain = coordinate_of_tip};
}

}  // namespace qerr
