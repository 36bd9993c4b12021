#include <limits>

#include "bound/signals/signals.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {

namespace {

/// Coordinates of the tip that a small motion of the joints moves by rows of the Jacobian: not roll, pitch
/// and yaw, whose rates have a lock.
std::vector<Coordinate> moved_coordinates(const OperationalModel& m) {
  std::vector<Coordinate> all;
  for (const Coordinate c : m.coordinates)
    if (!is_euler_angle(c)) all.push_back(c);
  return all;
}

/// The analysed coordinates of several tips.
std::vector<Signal> analysed_coordinates_of_tips(const OperationalModel& m) {
  std::vector<Signal> all;
  for (const Signal& s : m.signals)
    if (s.kind->of_chain) all.push_back(s);
  return all;
}

std::vector<Signal> positions(const OperationalModel& m) {
  std::vector<Signal> all = loop_signals(m, "closed_position.", false);
  if (all.size() != m.chain.independent.size()) return all;  // a joint without a loop moves the tip, too
  for (const Coordinate c : moved_coordinates(m))
    all.push_back({"closed_position." + std::string(info(c).name), std::string(info(c).unit)});
  for (const Signal& s : analysed_coordinates_of_tips(m))
    all.push_back({"closed_position." + s.name, s.unit});
  return all;
}

Eigen::RowVectorXd row_of(const OperationalModel& m, std::size_t index, const Eigen::VectorXd& q) {
  const std::size_t joints = looped_joints(m).size();
  if (index < joints) return joint_row(m, index, q);
  if (m.tips) {
    const Signal s = analysed_coordinates_of_tips(m)[index - joints];
    return s.kind->row(m, s.index, q);
  }
  Eigen::Isometry3d pose;
  const Jacobian j = joint_jacobian(m.chain, q, &pose);
  const Coordinate c = moved_coordinates(m)[index - joints];
  return to_independent(m.chain, coordinate_rows({c}, j, pose.linear(), m.frame));
}

}  // namespace

/// The true motion of a joint in its closed loop, -L/(1 + L) times the error of its reading; and of the tip,
/// J times those of the joints, whose loops are decoupled.
SignalKind closed_position_signal() {
  return {
      .group = "closed_position",
      .summary = "true motion in the closed loops of `control:`, closed_position.JOINT or .x",
      .signals = positions,
      .row = row_of,
      .remainder =
          [](const OperationalModel& m, std::size_t index, const Eigen::VectorXd&, const Eigen::VectorXd&) {
            return index < looped_joints(m).size() ? 0.0 : std::numeric_limits<double>::infinity();
          },
      .norms =
          [](const OperationalModel& m, std::size_t index, const Eigen::VectorXd& q,
             const Eigen::MatrixXd& moved,
             const LoopsAt& loops) { return norms_in_loops(m, row_of(m, index, q), moved, loops, false); }};
}

}  // namespace qerr
