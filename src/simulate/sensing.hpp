#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "effect/action_path.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/core/instruction_set.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/simulate/simulate.hpp"
#include "simulate/count_errors.hpp"
#include "simulate/motion_path.hpp"

namespace qerr {

/// Signals at `batch_size` samples: of each signal one row of samples for every joint or encoder, aligned to
/// 64 bytes. Meanings and units as in `Reading`. Borrows memory of `Sensing`, valid until its next batch.
struct SensedBatch {
  std::uint64_t first = 0;  ///< number of the first sample
  const double *time, *joint, *encoder;
  const double* counts;  ///< rising with the joint, whatever the sign of the gear ratio
  const double *measured, *estimate;
  const double* effort;  ///< null unless requested
  const double* shift;   ///< displacement of each joint from the path, constant during a run
};

/// Joint positions of a motion at `batch_size` samples, which all runs along it share.
class PathBatch {
 public:
  explicit PathBatch(const Motion&, InstructionSet = instruction_set());

  /// Evaluates samples first .. first + count - 1 at time index / sample_rate; the batch is filled with
  /// copies of the last one.
  void at(std::uint64_t first, std::size_t count);

  std::uint64_t first() const { return first_; }
  std::size_t count() const { return count_; }
  const double* time() const { return time_.data(); }
  const double* joints() const { return joints_.data(); }  ///< a row for each joint [rad or m]
  const MotionPath& path() const { return path_; }

 private:
  MotionPath path_;
  double sample_rate_;
  InstructionSet set_;
  std::uint64_t first_ = 0;
  std::size_t count_ = 0;
  AlignedNumbers time_, joints_;
};

/// The chain as built: with the joint origins displaced by effects of stage `kinematics`.
Chain as_built(const Chain&, const std::vector<Effect>&);

/// Whether an effect depends on the efforts of the joints.
bool needs_effort(const std::vector<Effect>&);

/// Simulates the encoders during one run along a motion, in the order of time: sample by sample or in
/// batches.
///
/// Effects act in the order of `Stage`: the clock sets the instant at which the joint is read, compliance and
/// backlash act between joint and encoder shaft, disc, line and comparator distort the input of the
/// quantizer, and the decoder counts. Encoders without effects are evaluated for many samples at once, with
/// the same counts.
class Sensing {
 public:
  struct Options {
    Eigen::VectorXd displacement;  ///< constant displacement of the encoder coordinates [rad or m]; less than
                                   ///< a count, it only shifts the phase of the quantizer
    std::uint64_t seed = 0;        ///< of the random effects of this run
    bool effort = false;  ///< compute efforts in any case, if the robot has masses or the motion states
                          ///< them; otherwise only if an effect needs them
    /// Whether positions are rounded to counts. If not, a count is position/Delta and what effects change in
    /// its mean over the position of the encoder's zero and over the noise: it is not an integer.
    bool rounds = true;
  };
  Sensing(const OperationalModel&, const Motion&, const std::vector<Effect>&, const Options&,
          InstructionSet = instruction_set());

  /// Simulates samples first .. first + count - 1 at time index / sample_rate; the batch is filled with
  /// copies of the last one.
  /// @param count  at most batch_size; less only at the end of the motion
  /// @pre called with 0, batch_size, 2 batch_size, ...
  /// @throws Error (input; key `effects`) if a count exceeds 2^53
  const SensedBatch& sense(std::uint64_t first, std::size_t count = batch_size);

  /// What the sensors read at the samples of a given path.
  const SensedBatch& sense(const PathBatch&);

  /// A sample of the last batch.
  /// @pre called for every sample, in order
  Reading& reading(std::size_t in_batch);

  /// The sample `index`; a batch is simulated when its first sample is read.
  /// @pre called with 0, 1, 2, ...; `sense` is not called
  Reading& read(std::uint64_t index);

  const Chain& built() const { return built_; }

 private:
  struct Actions {
    ActionPath clock, motion, encoder, log, reference;
    Decoder decoder;
  };
  double position(std::size_t joint, double time) const;
  Eigen::VectorXd effort(double time) const;
  Eigen::VectorXd dynamic_effort(double time) const;
  double temperature_rise(std::size_t joint, double time) const;
  double shaft_position(std::size_t joint, std::size_t in_batch);
  double count(std::size_t encoder, double shaft, std::size_t in_batch);
  double count_of(std::size_t encoder, double position) const;
  Moment moment(std::size_t joint, std::size_t in_batch) const;
  /// The motion with an effort. Where both are measured, by differences over some hundredths of a second: the
  /// second derivative of the path through all rows would be that of their noise.
  JointState driven(std::size_t joint, double time) const;
  const double* mixed(const Coupling&, const AlignedNumbers& from, const AlignedNumbers& to) const;
  const double* shaft_positions(std::size_t count);
  void count_shaft(std::size_t encoder, const double* shaft, std::size_t count);
  static void repeat_last(const AlignedNumbers& rows, std::size_t count);
  [[noreturn]] void fail_to_count(std::size_t encoder, std::size_t in_batch) const;

  Chain built_;
  Transmission transmission_;
  PathBatch path_;
  Coupling to_encoders_;
  Eigen::VectorXd shift_;  // of the joints
  std::vector<Actions> actions_;
  bool masses_, effort_, temperature_,
      shaft_differs_;  // efforts are computed; shaft angles differ from the true joint angles
  bool rounds_;
  Eigen::VectorXd mean_rounding_;  // of the encoders without effects
  InstructionSet set_;
  AlignedNumbers joint_, encoder_, shaft_joint_, shaft_, counts_, measured_, estimate_, efforts_;
  SensedBatch batch_;
  Reading reading_;
};

}  // namespace qerr
