#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/core/instruction_set.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/simulate/motion.hpp"

namespace qerr {

/// The gap between IPQN at the centre of the motion and the simulation, in factors:
/// sigma_ipqn * varying_jacobian * joint_error * correlated_joints * nonlinear = sigma_simulated. NaN for
/// roll and yaw of a motion that meets the gimbal lock, where their Jacobian has no bound.
struct Ladder {
  double varying_jacobian = 1;  ///< IPQN with the Jacobian along the path, over IPQN at the centre
  double joint_error = 1;  ///< each encoder's simulated error through J(t) and filter, summed in variance
  double correlated_joints = 1;  ///< their sum, as it is
  double nonlinear = 1;          ///< exact kinematics instead of J, and the robot as it was built
};

/// One coordinate behind one filter: theory beside simulation [m or rad, per s^derivative]. Theory is
/// infinite for roll and yaw at the gimbal lock.
struct SimulatedSignal {
  double sigma_simulated = 0;               ///< about the mean, over samples and runs
  double sigma_lower = 0, sigma_upper = 0;  ///< 95 % interval of it: between runs, or within a single one
  double mean_simulated = 0;
  double peak_simulated = 0;
  double sigma_ipqn = 0;       ///< ||H||_2 sigma_x at the centre of the motion
  double sigma_ipqn_path = 0;  ///< the same, root mean square along the path, with what a mean varies there
  /// With the encoders' speeds along the path (noise_along_motion.hpp); NaN behind a filter that remembers
  /// more than `longest_autocorrelation` samples.
  double sigma_exact = 0;
  double worst_case = 0;  ///< bound (26) at the centre
  double worst_case_path =
      0;  ///< largest along the path, with the second-order remainder: never exceeded but by Gaussians
  Ladder ladder;
};

struct Simulation {
  std::uint64_t runs = 0;
  std::uint64_t samples = 0;                          ///< of one run
  std::uint64_t settling = 0;                         ///< samples of each run left out of the statistics
  std::vector<std::vector<SimulatedSignal>> results;  ///< [0: position, then the filters][coordinate]
};

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

struct SimulationOptions {
  std::uint64_t runs = 1;
  bool random_phase = false;  ///< every run is displaced by a random part of each encoder's count
  std::uint64_t seed = 1;
  unsigned threads = 0;
  InstructionSet instructions = instruction_set();
  std::function<void(std::uint64_t done, std::uint64_t total)> progress = {};
  std::function<void(const Reading&)> visit = {};  ///< every sample of the first run, in order
};

/// Explicit quantizers along a motion, exact kinematics, and the filters on what comes out.
///
/// What the model says of effects (`sources`) enters the bounds and the means that the Jacobian carries along
/// the path; sigma_ipqn and its kin stay those of quantization alone, so that the ladder shows what the
/// effects add.
///
/// A filter of a lower rate takes every n-th sample; its rate must divide the motion's.
/// @throws Error (input; key `motion.sample_rate`) when a filter's rate does not
Simulation simulate(const OperationalModel&, const std::vector<Filter>&, const std::vector<Norms>&,
                    const Motion&, const std::vector<Effect>&, const SimulationOptions& = {});

/// Where the motion is centred: centers of sines, the middle of anything else [rad or m].
Eigen::VectorXd center(const Motion&);

}  // namespace qerr
