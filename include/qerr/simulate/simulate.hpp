#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/core/instruction_set.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

/// amplitude * sin(2 pi frequency t + phase).
struct Sine {
  double amplitude = 0;  ///< [rad or m]
  double frequency = 0;  ///< [Hz]
  double phase = 0;      ///< [rad]
};

struct Oscillation;

/// One move of a point-to-point motion: from standstill to standstill, then a dwell.
struct Move {
  double to = 0;            ///< final position [rad or m]
  double velocity = 0;      ///< limit [rad/s or m/s]
  double acceleration = 0;  ///< limit [rad/s^2 or m/s^2]
  double jerk = 0;          ///< limit [rad/s^3 or m/s^3]; 0: trapezoidal velocity
  double dwell = 0;         ///< pause after the move [s]
};

/// Motion of one joint: center + velocity t + sum of sines, or a sequence of moves that starts at the center
/// and is repeated.
struct JointMotion {
  double center = 0;    ///< [rad or m]
  double velocity = 0;  ///< [rad/s or m/s]
  std::vector<Sine> sines;
  std::vector<Move> moves;
};

/// What a table has of a joint beside its position, at the same times.
struct RecordedSignal {
  std::string unit;        ///< as in a log: "N m", "A", "K", ...
  Eigen::VectorXd values;  ///< empty: it has none
};

/// A recorded or planned motion.
struct MotionTable {
  std::vector<double> time;   ///< strictly increasing [s]
  Eigen::MatrixXd positions;  ///< independent joints x times [rad or m]
  /// Of every independent joint: the load of its gear, and the temperature.
  std::vector<RecordedSignal> efforts = {}, temperatures = {};
};

/// Whether the motion states the effort, or the temperature, of any joint.
bool states_any(const std::vector<RecordedSignal>&);

/// `motion:` of the spec: the motion of every independent joint from time 0 to `duration`.
struct Motion {
  double sample_rate = 0;           ///< of the controller that reads the encoders [Hz]
  double duration = 0;              ///< [s]
  std::optional<double> settling;   ///< initial part that statistics exclude [s]
  std::vector<JointMotion> joints;  ///< one per independent joint; empty if a table gives the motion
  MotionTable table;                ///< time 0 of the motion is its first row
  std::string file = {};            ///< of the table; "" without a table
};

/// Lowest and highest position of every independent joint at the samples 0, 1/sample_rate, ... of the motion.
/// @returns joints x 2 [rad or m]
Eigen::MatrixX2d extent(const Motion&);

/// Ratio of the simulated sigma to IPQN at the centre of the motion, factorized:
/// sigma_ipqn * varying_jacobian * joint_error * correlated_joints * nonlinear = sigma_simulated. NaN for
/// roll and yaw of a motion through the gimbal lock, where their Jacobian is unbounded.
struct Ladder {
  double varying_jacobian = 1;  ///< IPQN with the Jacobian along the path / IPQN at the centre
  double joint_error = 1;  ///< simulated errors of the encoders through J(t) and the filter, variances summed
  double correlated_joints = 1;  ///< variance of their sum / sum of their variances, as sigmas
  double nonlinear = 1;          ///< exact kinematics of the robot as built instead of J
};

/// One coordinate after one filter: simulation and theory [m or rad, per s^derivative]. Theory is infinite
/// for roll and yaw at the gimbal lock.
struct SimulatedSignal {
  double sigma_simulated = 0;               ///< about the mean, over samples and runs
  double sigma_lower = 0, sigma_upper = 0;  ///< its 95 % interval, between runs or within a single run
  double mean_simulated = 0;
  double peak_simulated = 0;
  double sigma_ipqn = 0;       ///< ||H||_2 sigma_x at the centre of the motion
  double sigma_ipqn_path = 0;  ///< root mean square along the path, with the variation of the mean
  /// Without the assumption IPQN: root of the mean over the position of the encoders' zeros, equally spaced
  /// in a count, and over the samples of the mean square of the linear error J e behind the filter, summed
  /// over the encoders (quantization_along_motion.hpp). NaN if an encoder moves by less than a quarter of a
  /// count.
  double sigma_exact = 0;
  double worst_case = 0;  ///< bound (26) at the centre
  double worst_case_path =
      0;  ///< largest along the path, with the linearization remainder; only Gaussian effects can exceed it
  Ladder ladder;
  /// What the filter does to the true signal (SimulationOptions::tracking): root mean square and peak of the
  /// filtered true position minus its true derivative; NaN if not asked for, and for rotations and third
  /// derivatives.
  double tracking_rms = std::numeric_limits<double>::quiet_NaN();
  double tracking_peak = std::numeric_limits<double>::quiet_NaN();
  /// Root mean square of the estimate minus the true derivative: errors of the encoders and of the filter.
  double total_rms = std::numeric_limits<double>::quiet_NaN();
};

/// The error of every coordinate behind one filter in the first run, from the end of the settling on, sample
/// by sample of the filter [m or rad, per s^derivative].
struct ErrorTrace {
  double first_time = 0;                   ///< [s]
  double sample_rate = 0;                  ///< [Hz]
  std::vector<std::vector<double>> error;  ///< [coordinate][sample]
};

struct Simulation {
  std::uint64_t runs = 0;
  std::uint64_t samples = 0;                          ///< of one run
  std::uint64_t settling = 0;                         ///< samples of each run that statistics exclude
  std::vector<std::vector<SimulatedSignal>> results;  ///< [0: position, then the filters][coordinate]
  std::vector<ErrorTrace> traces = {};                ///< the same order; empty: not asked for
};

/// A velocity estimator that is no linear filter, with its checked parameters in SI units.
struct EstimatorDesign {
  std::string name;
  std::string kind;  ///< name of a row of `qerr list estimators`
  std::map<std::string, double> numbers;
  std::map<std::string, std::string> choices;
  std::vector<std::size_t> joints = {};  ///< independent joints that have it; empty: all
};

/// Root mean square error of an estimate at about one speed.
struct ErrorAtSpeed {
  double speed = 0, rms = 0;  ///< magnitudes [rad/s or m/s]
};

/// One estimate of one joint's velocity along a motion, over all runs, behind the settling [rad/s or m/s].
struct EstimatedVelocity {
  std::string estimator, kind;  ///< kind "filter" of a filter
  std::size_t joint = 0;
  double rms = 0;    ///< of the estimate minus the true velocity at the same instant
  double worst = 0;  ///< largest magnitude of that
  /// By which the true velocity must be late to fit the estimate best [s]; empty: it never changes, or an
  /// estimate that follows it by no delay.
  std::optional<double> delay;
  double noise = 0;     ///< rms of the estimate minus the true velocity at that delay
  double tracking = 0;  ///< rms of what the delay alone makes
  /// Bound of the error that the counts make, of the timing of edges at a constant speed; empty: none is
  /// known.
  std::optional<double> worst_case;
  std::vector<ErrorAtSpeed> by_speed;  ///< in classes of the speed, ascending
};

/// Signals of controller and reference sensor at one sample.
struct Reading {
  std::uint64_t index = 0;
  double time = 0;          ///< time stamp [s]
  Eigen::VectorXd joint;    ///< true positions of the independent joints at that time [rad or m]
  Eigen::VectorXd counts;   ///< what the encoders' counters show, integers
  Eigen::VectorXd encoder;  ///< true encoder coordinates C^-1 q [rad or m]
  Eigen::VectorXd
      measured;  ///< measured encoder coordinates, counts * Delta in the counter's direction [rad or m]
  Eigen::VectorXd estimate;   ///< measured joint positions C * measured [rad or m]
  Eigen::VectorXd logged;     ///< the estimate with the effects of the log [rad or m]
  Eigen::VectorXd reference;  ///< joint positions by the reference sensor [rad or m]
  Eigen::VectorXd effort;     ///< of the joints; empty unless requested [N m or N, or as the motion's table]
  Eigen::VectorXd temperature_rise;  ///< of the joints; empty unless the motion's table has it [K]
  Eigen::Isometry3d tip;             ///< true pose of the tip, in the tracker's frame
};

struct SimulationOptions {
  std::uint64_t runs = 1;
  bool tracking = false;      ///< also the errors that the filters make without any of the encoders
  bool exact = true;          ///< compute sigma_exact, which takes runs of its own; else it is NaN
  std::uint64_t traced = 0;   ///< samples of the motion, behind the settling, whose errors are kept
  bool random_phase = false;  ///< every run is displaced by a random fraction of a count of each encoder
  std::uint64_t seed = 1;
  unsigned threads = 0;
  InstructionSet instructions = instruction_set();
  std::function<void(std::uint64_t done, std::uint64_t total)> progress = {};
  std::function<void(const Reading&)> visit = {};  ///< every sample of the first run, in order
};

/// Simulates explicit quantizers along a motion with exact kinematics, and filters the resulting errors.
///
/// Error sources of the model (`sources`) contribute to the bounds and to the mean error along the path.
/// sigma_ipqn, sigma_ipqn_path and sigma_exact are those of quantization alone, so that the ladder shows the
/// contribution of the effects.
///
/// A filter of a lower rate uses every n-th sample; its rate must divide that of the motion.
/// @throws Error (input; key `motion.sample_rate`) if it does not
Simulation simulate(const OperationalModel&, const std::vector<Filter>&, const std::vector<Norms>&,
                    const Motion&, const std::vector<Effect>&, const SimulationOptions& = {});

/// The centre of the motion: for sines their center, else the middle of the range [rad or m].
Eigen::VectorXd center(const Motion&);

}  // namespace qerr
