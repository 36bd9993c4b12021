#include <algorithm>

#include "bound/signals/signals.hpp"
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
  return Eigen::RowVectorXd::Unit(q.size(), looped_joints(m)[index]);
}

SignalNorms norms_in_loops(const OperationalModel&, const Eigen::RowVectorXd& row,
                           const Eigen::MatrixXd& moved, const LoopsAt& loops, bool torque) {
  SignalNorms n{Eigen::RowVectorXd::Zero(moved.cols()), Eigen::RowVectorXd::Zero(moved.cols()),
                Eigen::RowVectorXd::Zero(moved.cols())};
  for (Eigen::Index e = 0; e < moved.cols(); ++e) {
    std::vector<std::size_t> joints;
    std::vector<double> weights;
    ResponseNorms sum;  // of the triangle inequality
    bool stable = true;
    for (Eigen::Index j = 0; j < row.size(); ++j) {
      const double weight = row[j] * moved(j, e);
      if (weight == 0) continue;
      joints.push_back(static_cast<std::size_t>(j));
      weights.push_back(weight);
      const LoopNorms of_joint = loops.norms(joints.back());
      const ResponseNorms& own = torque ? of_joint.torque : of_joint.motion;
      stable = stable && of_joint.stable();
      sum.l1 += std::abs(weight) * own.l1;
      sum.h2 += std::abs(weight) * own.h2;
      sum.dc += weight * own.dc;
    }
    // Of several loops the responses themselves are added, if the recursion has them all.
    if (joints.size() > 1 && stable) {
      std::vector<const std::vector<double>*> responses;
      for (const std::size_t j : joints) {
        const LoopResponse& response = loops.response(j);
        stable = stable && response.stable;
        responses.push_back(torque ? &response.torque : &response.motion);
      }
      if (stable) {
        const ResponseNorms together = norms_of_sum(responses, weights);
        // Of a slow error the triangle inequality knows the frequencies, the sum the signs.
        if (loops.slow)
          sum.l1 = std::min(sum.l1, together.l1);
        else
          sum = together;
      }
    }
    n.l1[e] = sum.l1;
    n.h2[e] = sum.h2;
    n.dc[e] = sum.dc;
  }
  return n;
}

}  // namespace qerr
