#pragma once

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
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

/// Norms of a joint's closed loop; infinite of an unstable one.
struct LoopNorms {
  ResponseNorms motion, torque;

  bool stable() const { return std::isfinite(motion.l1); }
};

/// The norms of `loop_response` at each of several inertias: the recursions run side by side.
std::vector<LoopNorms> loop_norms(const JointController&, const std::vector<double>& inertias,
                                  double sample_rate, double samples_of_delay);

/// A loop whose inertia is stated: its norms, certified, and its response, once for all configurations and
/// threads.
struct StatedLoop {
  std::once_flag of_norms, of_response;
  LoopNorms norms;
  LoopResponse response;
};

/// Whether two joints of one control close the same loop. @pre both inertias are stated
bool close_the_same(const JointController&, const JointController&);

/// Gives each joint of a stated inertia a loop that is not yet evaluated, in place of one of other gains.
Control with_stated_loops(Control);

/// The loops of all joints at some configurations, each evaluated when it is first asked for.
class LoopsOfBatch {
 public:
  /// @param control  may be null: there are no loops
  LoopsOfBatch(std::shared_ptr<const Control> control, const Chain&);

  /// @param q  joints x configurations
  void move_to(Eigen::MatrixXd q);

  const LoopNorms& norms(std::size_t joint, Eigen::Index configuration);
  /// Only where responses of several loops are added: else their norms say all.
  const LoopResponse& response(std::size_t joint, Eigen::Index configuration);

 private:
  struct OfJoint {
    std::vector<double> inertias;  // of the configurations; empty: not known yet
    std::vector<LoopNorms> norms;
    std::vector<std::optional<LoopResponse>> responses;
  };
  OfJoint& of_joint(std::size_t joint);

  std::shared_ptr<const Control> control_;
  Chain chain_;
  Eigen::MatrixXd q_;
  std::vector<OfJoint> joints_;
};

}  // namespace qerr
