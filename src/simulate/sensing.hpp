#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "lanes/aligned.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/core/instruction_set.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/simulate/simulate.hpp"
#include "simulate/motion_path.hpp"

namespace qerr {

/// What a controller records at `batch_size` samples: each a row of them for every joint or encoder, aligned
/// to 64 bytes. Meanings and units as in `Reading`.
struct SensedBatch {
  std::uint64_t first = 0;  ///< number of the first sample
  const double *time, *joint, *encoder, *counts, *measured, *estimate;
  const double* effort;  ///< null unless asked for
  const double* shift;   ///< of each joint from the path: the same in all of a run
};

/// Where the joints of a motion are at `batch_size` samples: what all runs along it share.
class PathBatch {
 public:
  explicit PathBatch(const Motion&, InstructionSet = instruction_set());

  /// Samples first .. first + count - 1, at time index / sample_rate; behind them the last one again and
  /// again.
  void at(std::uint64_t first, std::size_t count);

  std::uint64_t first() const { return first_; }
  std::size_t count() const { return count_; }
  const double* time() const { return time_.data(); }
  const double* joints() const { return joints_.data(); }  ///< a row of each [rad or m]
  const MotionPath& path() const { return path_; }

 private:
  MotionPath path_;
  double sample_rate_;
  InstructionSet set_;
  std::uint64_t first_ = 0;
  std::size_t count_ = 0;
  AlignedNumbers time_, joints_;
};

/// The chain as it was built: with the joints displaced that `geometry` effects displace.
Chain as_built(const Chain&, const std::vector<Effect>&);

/// Whether an effect needs to know the joints' efforts.
bool needs_effort(const std::vector<Effect>&);

/// One run of the robot's encoders along a motion, in the order of time: sample by sample, or in batches.
///
/// The joint moves, is read at its clock's instant, winds up and plays, and turns the encoder's shaft; disc,
/// line and comparator distort what the quantizer sees; the decoder counts. The order of the stages is that
/// of `Stage`. What has no effect on its way is done for many samples at once, to the same counts.
class Sensing {
 public:
  struct Options {
    Eigen::VectorXd displacement;  ///< of the encoder coordinates during the whole motion [rad or m]: less
                                   ///< than a count shifts the phase of the quantizer and nothing else
    std::uint64_t seed = 0;        ///< of this run's random effects
    bool effort = false;  ///< read it, where the robot has masses; effects that need it have it anyway
  };
  Sensing(const OperationalModel&, const Motion&, const std::vector<Effect>&, const Options&,
          InstructionSet = instruction_set());

  /// Samples first .. first + count - 1, at time index / sample_rate; behind them the last one again and
  /// again.
  /// @param count  at most batch_size; less only at the end
  /// @pre called with 0, batch_size, 2 batch_size, ...
  /// @throws Error (input; key `effects`) where a count is beyond 2^53
  const SensedBatch& sense(std::uint64_t first, std::size_t count = batch_size);

  /// The same of samples whose path is known.
  const SensedBatch& sense(const PathBatch&);

  /// A sample of the batch sensed last.
  /// @pre called for every sample, in order
  Reading& reading(std::size_t in_batch);

  /// The sample `index`, of a batch that is sensed when its first sample is read.
  /// @pre called with 0, 1, 2, ...; `sense` is not
  Reading& read(std::uint64_t index);

  const Chain& built() const { return built_; }

 private:
  struct Actions {
    std::vector<Action> clock, motion, encoder, decoder, log, reference;
  };
  double position(std::size_t joint, double time) const;
  Eigen::VectorXd effort(double time) const;
  double turned(std::size_t joint, std::size_t in_batch);
  double count(std::size_t encoder, double shaft, std::size_t in_batch);
  Moment moment(std::size_t joint, std::size_t in_batch) const;
  const double* mixed(const Eigen::MatrixXd&, const AlignedNumbers& from, const AlignedNumbers& to) const;
  const double* turn_shafts(std::size_t count);
  void count_shaft(std::size_t encoder, const double* shaft, std::size_t count);
  static void repeat_last(const AlignedNumbers& rows, std::size_t count);
  [[noreturn]] void fail_to_count(std::size_t encoder, std::size_t in_batch) const;

  Chain built_;
  Transmission transmission_;
  PathBatch path_;
  Eigen::MatrixXd to_encoders_;
  bool uncoupled_;
  Eigen::VectorXd shift_;  // of the joints
  std::vector<Actions> actions_;
  bool effort_, turned_;  // efforts are known; shafts are elsewhere than the true joints
  InstructionSet set_;
  AlignedNumbers joint_, encoder_, turn_, shaft_, counts_, measured_, estimate_, efforts_;
  SensedBatch batch_;
  Reading reading_;
};

}  // namespace qerr
