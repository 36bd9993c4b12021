#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "control/loop_response.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/bound/signal.hpp"

namespace qerr {

#define QERR_SIGNAL(name) SignalKind name##_signal();
#include "bound/signals/list.inc"
#undef QERR_SIGNAL

/// What the signals of closed loops share.

/// The loops at one configuration of a batch. Borrows the batch.
struct LoopsAt {
  LoopsOfBatch* batch;
  Eigen::Index configuration;
  /// [joint]: what a slow error passes in place of the l1 norms, NaN where that is not known; null: the
  /// norms.
  const std::vector<LoopRatio>* slow = nullptr;

  LoopNorms norms(std::size_t joint) const {
    if (slow && joint < slow->size() && !std::isnan((*slow)[joint].motion))
      return {{(*slow)[joint].motion}, {(*slow)[joint].torque}};
    return batch->norms(joint, configuration);
  }
  const LoopResponse& response(std::size_t joint) const { return batch->response(joint, configuration); }
};

/// Indices of the independent joints whose loop can be closed; none without `control`.
std::vector<std::size_t> looped_joints(const OperationalModel&);

/// One signal for each of these joints. @param torque  in N m or N, else in rad or m
std::vector<Signal> loop_signals(const OperationalModel&, const std::string& before, bool torque);

/// The coordinate of one of these joints.
Eigen::RowVectorXd joint_row(const OperationalModel&, std::size_t index, const Eigen::VectorXd& q);

/// Norms of sum_j row_j G_j(z) moved_je for each error e, G_j being the transfer function of joint j's loop:
/// exact also where an error moves several joints.
SignalNorms norms_in_loops(const OperationalModel&, const Eigen::RowVectorXd& row,
                           const Eigen::MatrixXd& moved, const LoopsAt&, bool torque);

}  // namespace qerr
