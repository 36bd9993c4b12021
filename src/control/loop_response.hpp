#pragma once

#include <cmath>
#include <vector>

#include "control/control.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {

/// Responses of a joint's closed loop to an impulse of the reading's error, until they have decayed: the true
/// motion, -L/(1 + L), and the torque, -C/(1 + L).
struct LoopResponse {
  std::vector<double> motion, torque;
  bool stable = false;  ///< else both are empty
};

/// Norms of an impulse response; infinite of an unstable loop.
struct ResponseNorms {
  double l1 = 0, h2 = 0, dc = 0;
};

/// The responses by recursion in doubles: for inertias that vary with the configuration, where the certified
/// norms of `closed` would take too long. Truncated where two blocks of 256 samples and more have added less
/// than 1e-11 of the sum. A loop that has not decayed within 4e6 samples is taken as unstable.
LoopResponse loop_response(const JointController&, double inertia, double sample_rate,
                           double samples_of_delay);

ResponseNorms response_norms(const LoopResponse&, const std::vector<double> LoopResponse::*);

/// Norms of sum weights[i] * responses[i]; the responses may differ in length.
ResponseNorms norms_of_sum(const std::vector<const std::vector<double>*>& responses,
                           const std::vector<double>& weights);

/// The inertia that the controller states, else that of the URDF.
double inertia_at(const Control&, const Chain&, std::size_t joint, const Eigen::VectorXd& q);

/// Whether the joint's loop can be closed: it has a controller, and its inertia is known.
bool has_loop(const Control&, const Chain&, std::size_t joint);

/// A joint's response and its norms: certified where the inertia is stated, else those of the recursion.
struct KnownResponse {
  LoopResponse response;
  ResponseNorms motion, torque;  ///< infinite of an unstable loop

  bool stable() const { return std::isfinite(motion.l1); }
};

/// The response at a configuration; the last one of each joint and thread is kept, as neighbouring signals
/// ask for the same, and a stated inertia never changes. @returns valid until the thread's next call for the
/// joint
const KnownResponse& response_at(const Control&, const Chain&, std::size_t joint, const Eigen::VectorXd& q);

}  // namespace qerr
