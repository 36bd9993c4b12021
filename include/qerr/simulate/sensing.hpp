#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/simulate/motion.hpp"

namespace qerr {

/// What a controller and a better sensor record at one sample.
struct Reading {
  std::uint64_t index = 0;
  double time = 0;               ///< the stamp [s]
  Eigen::VectorXd joint;         ///< true positions of the independent joints at the stamp [rad or m]
  Eigen::VectorXd counts;        ///< of the encoders, whole numbers
  Eigen::VectorXd encoder;       ///< true encoder coordinates C^-1 q at the stamp [rad or m]
  Eigen::VectorXd measured;      ///< encoder coordinates as read, counts * Delta [rad or m]
  Eigen::VectorXd estimate;      ///< joint positions as read, C * measured [rad or m]
  Eigen::VectorXd logged;        ///< the estimate as a file with a grid of its own has it [rad or m]
  Eigen::Vector3d tip{0, 0, 0};  ///< true position of the tip, filled in by `simulate` [m]
  Eigen::VectorXd reference;     ///< joint positions by the better sensor [rad or m]
};

/// One run of the robot's encoders along a motion, sample by sample and in order.
///
/// The joint moves, is read at its clock's instant, winds up and plays, and turns the encoder's shaft; disc,
/// line and comparator distort what the quantizer sees; the decoder counts. The order of the stages is that
/// of `Stage`.
class Sensing {
 public:
  /// @param displacement  added to the encoder coordinates of the whole motion [rad or m]: less than a count
  /// shifts
  ///   the phase of the quantizer and nothing else
  /// @param seed  of this run's random effects
  Sensing(const OperationalModel&, const Motion&, const std::vector<Effect>&,
          const Eigen::VectorXd& displacement, std::uint64_t seed);

  /// The sample `index` at time index / sample_rate.
  /// @pre called with 0, 1, 2, ...
  Reading& read(std::uint64_t index);

 private:
  struct Actions {
    std::vector<Action> clock, motion, encoder, decoder, log, reference;
  };
  double position(std::size_t joint, double time) const;

  Transmission transmission_;
  MotionPath path_;
  double sample_rate_;
  Eigen::MatrixXd to_encoders_;
  Eigen::VectorXd shift_;  // of the joints
  std::vector<Actions> actions_;
  Reading reading_;
};

}  // namespace qerr
