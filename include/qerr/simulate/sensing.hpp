#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/simulate/motion.hpp"

namespace qerr {

/// What a controller and a better sensor record at one sample.
struct Reading {
  std::uint64_t index = 0;
  double time = 0;            ///< the stamp [s]
  Eigen::VectorXd joint;      ///< true positions of the independent joints at the stamp [rad or m]
  Eigen::VectorXd counts;     ///< of the encoders, whole numbers
  Eigen::VectorXd encoder;    ///< true encoder coordinates C^-1 q at the stamp [rad or m]
  Eigen::VectorXd measured;   ///< encoder coordinates as read, counts * Delta [rad or m]
  Eigen::VectorXd estimate;   ///< joint positions as read, C * measured [rad or m]
  Eigen::VectorXd logged;     ///< the estimate as a file with a grid of its own has it [rad or m]
  Eigen::VectorXd reference;  ///< joint positions by the better sensor [rad or m]
  Eigen::VectorXd effort;     ///< of the joints; empty unless asked for [N m or N]
  Eigen::Isometry3d tip;      ///< true pose of the tip
};

/// The chain as it was built: with the joints displaced that `geometry` effects displace.
Chain as_built(const Chain&, const std::vector<Effect>&);

/// Whether an effect needs to know the joints' efforts.
bool needs_effort(const std::vector<Effect>&);

/// One run of the robot's encoders along a motion, sample by sample and in order.
///
/// The joint moves, is read at its clock's instant, winds up and plays, and turns the encoder's shaft; disc,
/// line and comparator distort what the quantizer sees; the decoder counts. The order of the stages is that
/// of `Stage`.
class Sensing {
 public:
  struct Options {
    Eigen::VectorXd displacement;  ///< of the encoder coordinates during the whole motion [rad or m]: less
                                   ///< than a count shifts the phase of the quantizer and nothing else
    std::uint64_t seed = 0;        ///< of this run's random effects
    bool effort = false;  ///< read it, where the robot has masses; effects that need it have it anyway
  };
  Sensing(const OperationalModel&, const Motion&, const std::vector<Effect>&, const Options&);

  /// The sample `index` at time index / sample_rate.
  /// @pre called with 0, 1, 2, ...
  Reading& read(std::uint64_t index);

 private:
  struct Actions {
    std::vector<Action> clock, motion, encoder, decoder, log, reference;
  };
  double position(std::size_t joint, double time) const;
  Eigen::VectorXd effort(double time) const;
  double turned(std::size_t joint);
  double count(std::size_t encoder, double shaft);

  Chain built_;
  Transmission transmission_;
  MotionPath path_;
  double sample_rate_;
  Eigen::MatrixXd to_encoders_;
  Eigen::VectorXd shift_;  // of the joints
  std::vector<Actions> actions_;
  bool effort_;
  Reading reading_;
};

}  // namespace qerr
