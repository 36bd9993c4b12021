#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "diagnose/record/evidence.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

/// Record of a tracked tip: its positions, and the best known joint positions (by the joint's reference where
/// there is one, else by its encoder).
struct TipEvidence {
  bool ordered = true;             ///< the rows follow each other in time
  std::vector<Eigen::Index> axes;  ///< tracked coordinates: 0 x, 1 y, 2 z
  Eigen::MatrixXd tip;             ///< tracked coordinates x rows [m]
  Eigen::MatrixXd joints;          ///< independent joints x rows [rad or m]
  Eigen::VectorXd joint_noise;     ///< of the joints' references, 0 without one [rad or m]
  Eigen::MatrixXd to_joints;       ///< joints x encoders: the coupling, 0 in rows of joints with a reference
  std::vector<Evidence> encoders;  ///< path, speed, direction and load of every encoder, as read
  double noise = 0;                ///< of the tracker, per coordinate; 0: unknown [m]
  double log_resolution = 0;       ///< rounding step of the logged coordinates [m]

  Eigen::Index rows() const { return tip.cols(); }
  bool judged(std::size_t encoder) const {  ///< whether the tip is the only truth of this encoder
    return !to_joints.col(static_cast<Eigen::Index>(encoder)).isZero();
  }
};

/// The evidence at the tip, with equal rows merged (see `independent`), and of long records every n-th of
/// these.
/// @param present  effects that the spec already has: they displace the joints of the model
/// @returns empty if the log lacks the tip or a joint
std::optional<TipEvidence> tip_evidence(const OperationalModel&, const std::vector<Effect>& present,
                                        const Log&, unsigned threads);

}  // namespace qerr
