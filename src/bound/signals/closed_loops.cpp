#include "bound/signals/closed_loops.hpp"

#include "control/loop_response.hpp"

namespace qerr {

std::vector<std::size_t> looped_joints(const OperationalModel& m) {
  std::vector<std::size_t> joints;
  for (std::size_t j = 0; m.control && j < m.control->joints.size(); ++j)
    if (has_loop(*m.control, m.chain, j)) joints.push_back(j);
  return joints;
}

std::vector<Signal> loop_signals(const OperationalModel& m, const std::string& before, bool torque) {
  std::vector<Signal> signals;
  for (const std::size_t j : looped_joints(m)) {
    const IndependentJoint& joint = m.chain.independent[j];
    const std::string name = find_coordinate(joint.name) ? "joint:" + joint.name : joint.name;
    signals.push_back({before + name, joint.prismatic() ? (torque ? "N" : "m") : (torque ? "N m" : "rad")});
  }
  return signals;
}

Eigen::RowVectorXd joint_row(const OperationalModel& m, std::size_t index, const Eigen::VectorXd& q) {
  return Eigen::RowVectorXd::Unit(q.size(), static_cast<Eigen::Index>(looped_joints(m)[index]));
}

SignalNorms loop_norms(const OperationalModel& m, const Eigen::RowVectorXd& row, const Eigen::VectorXd& q,
                       const Eigen::MatrixXd& moved, bool torque) {
  SignalNorms n{Eigen::RowVectorXd::Zero(moved.cols()), Eigen::RowVectorXd::Zero(moved.cols()),
                Eigen::RowVectorXd::Zero(moved.cols())};
  for (Eigen::Index e = 0; e < moved.cols(); ++e) {
    std::vector<const std::vector<double>*> responses;
    std::vector<double> weights;
    const KnownResponse* only = nullptr;
    for (Eigen::Index j = 0; j < row.size(); ++j) {
      const double weight = row[j] * moved(j, e);
      if (weight == 0) continue;
      only = &response_at(*m.control, m.chain, static_cast<std::size_t>(j), q);
      responses.push_back(torque ? &only->response.torque : &only->response.motion);
      weights.push_back(weight);
      if (!only->response.stable) break;  // unbounded, whatever the others do
    }
    if (!only) continue;
    const bool one = weights.size() == 1 || !only->response.stable;
    const double factor = one ? weights.back() : 1;
    const ResponseNorms r = !one ? norms_of_sum(responses, weights) : torque ? only->torque : only->motion;
    n.l1[e] = std::abs(factor) * r.l1;
    n.h2[e] = std::abs(factor) * r.h2;
    n.dc[e] = factor * r.dc;
  }
  return n;
}

}  // namespace qerr
