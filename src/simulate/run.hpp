#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "kinematics/folded_chain.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/simulate.hpp"
#include "simulate/kernels.hpp"
#include "simulate/sensing.hpp"

namespace qerr {

/// Mean, variance and peak of many channels. The scatter of the variance between blocks of the record gives
/// the confidence interval of sigma of the first channels without assumptions on the spectrum of the error.
///
/// Samples are added in the order of time. Squares are summed about the first value of a piece of n <= 4096
/// samples. Its distance from the mean is at most sqrt(n) standard deviations, so that cancellation loses at
/// most 4 digits for any mean.
class RunStatistics {
 public:
  struct Interval {
    double lower = 0, upper = 0;
  };

  /// @param expected  number of first channels whose relative variance between blocks is known from theory
  /// (`expect`) and whose peak is computed
  /// @param width     of a row: the number of channels, padded to whole lanes
  RunStatistics(Eigen::Index channels, Eigen::Index expected, std::size_t width, std::uint64_t blocks,
                const SimulationKernels&);

  /// Adds rows of channels, `stride` numbers apart, all of one block.
  void add(const double* values, std::size_t stride, std::size_t rows, std::uint64_t block);

  /// Adds to the variance that theory expects of one of the first channels.
  /// @param variance  sum over rows of a block, up to a common factor
  void expect(Eigen::Index channel, double variance, std::uint64_t block) {
    blocks_[block].expected[channel] += variance;
  }

  /// Completes the statistics after the last sample.
  void finish();

  /// Appends the blocks of a later run.
  /// @pre both are finished
  void append(const RunStatistics& later);

  double mean(Eigen::Index channel) const;
  double variance(Eigen::Index channel) const;  ///< about the mean over all blocks
  /// Mean of the variances that theory expects of one of the first channels.
  double expected(Eigen::Index channel) const;
  /// Largest absolute value of one of the first channels.
  double peak(Eigen::Index channel) const { return peak_[channel]; }

  /// 95 % interval of sigma by Student's t of the mean squares of the blocks. Their variation between blocks
  /// that theory predicts is not counted as uncertainty (a ratio estimator).
  Interval sigma_interval(Eigen::Index channel) const;

  /// 95 % interval of the sigma of all runs, given the variance over a few other runs: that variance less the
  /// 97.5 % and 2.5 % quantiles of its error, in 2000 draws of as many of these runs for the variance and of
  /// all of them for the truth (bootstrap). Runs of slow motions are far from normally distributed, and two
  /// of them may agree by chance.
  Interval sigma_interval_of(std::uint64_t runs, double variance, Eigen::Index channel) const;

 private:
  struct Sums {
    double count = 0;
    Eigen::ArrayXd mean, squares, expected;  ///< squares about the mean, to avoid cancellation

    void join(double other_count, Eigen::Index channel, double other_mean, double other_squares);
    void join(const Sums& other);
  };
  void close_piece();
  void join_neighbours();
  template <class Sum>
  double per_sample(Sum of_block) const;  // over all blocks

  std::vector<Sums> blocks_;
  Eigen::ArrayXd peak_;  // of the first channels
  std::size_t width_;
  const SimulationKernels* kernels_;
  // The piece: samples of one block that are summed about the same values.
  AlignedNumbers numbers_;
  ChannelTally tally_{};
  std::size_t count_ = 0;
  std::uint64_t block_ = 0;
};

/// Layout of the filtered signals of every coordinate: the exact error, its linear part J e, the contribution
/// of every encoder to that, and, if errors have a mean, the mean error along the path.
struct Channels {
  Eigen::Index coordinates, encoders;
  bool biased;

  explicit Channels(const OperationalModel& model)
      : coordinates(std::ssize(model.coordinates)),
        encoders(std::ssize(model.transmission.encoders)),
        biased((mean_errors(model.transmission).array() != 0).any() ||
               std::ranges::any_of(model.sources,
                                   [](const IndependentError& source) { return source.mean != 0; })) {}

  Eigen::Index count() const { return coordinates * (2 + encoders + (biased ? 1 : 0)); }
  Eigen::Index linear() const { return coordinates; }
  Eigen::Index part(Eigen::Index encoder) const { return coordinates * (2 + encoder); }
  Eigen::Index mean() const { return coordinates * (2 + encoders); }
};

/// Errors of the tip along a run, a batch of instants at a time: at each instant equal to `tip_error` and
/// `operational_error` up to rounding.
class PathErrors {
 public:
  /// @param built        the chain as it was built
  /// @param center_mean  of the error at the centre of the motion
  PathErrors(const OperationalModel&, const Chain& built, const Eigen::VectorXd& center_mean,
             InstructionSet = instruction_set());

  /// Computes the quantities that several runs along this path share, valid until the next call.
  void share(const PathBatch&);

  /// @pre the batch is full; after the end of a motion its last instant is repeated
  void operator()(const SensedBatch&);

  /// Width of a row: the number of channels, padded to whole lanes.
  std::size_t width() const { return plan_.width; }
  /// Channels of the last batch, [instant][width].
  const double* rows() const { return rows_.data(); }

  /// The sum over the instants first .. last - 1 of the last batch, and over all encoders, of (J C Delta)^2.
  double variance(Eigen::Index coordinate, std::size_t first, std::size_t last) const {
    const double* const values = variance_.data() + static_cast<std::size_t>(coordinate) * batch_size;
    return Eigen::Map<const Eigen::ArrayXd>(values + first, last - first).sum();
  }
  /// Largest bounds over all batches so far: of the error, and of its difference from the mean at the centre.
  Eigen::VectorXd rigorous() const { return largest(rigorous_); }
  Eigen::VectorXd deviation() const { return largest(deviation_); }

 private:
  void add_columns(const OperationalModel&);
  void add_column(const Chain&, const Eigen::VectorXd& of_independent, double mean, double half_width);
  void add_origin(const IndependentError&);
  void fix_scale(const OperationalModel&);
  void bound(const OperationalModel&);
  void set_plan(const OperationalModel&);
  bool within_lanes(const FoldedChain&, const double* joints) const;
  bool displace(const double* shift);
  void reduce_angles(const FoldedChain&, const double* joints, const AlignedNumbers& to) const;
  Eigen::VectorXd largest(const AlignedNumbers&) const;

  Channels channels_;
  FoldedChain chain_, built_;
  bool as_modelled_;
  const SimulationKernels& kernels_;
  std::vector<double> scale_, per_resolution_, per_column_, center_mean_;
  std::vector<ErrorColumn> columns_;
  std::vector<ColumnPart> parts_;
  std::vector<int> coordinates_;
  PathErrorPlan plan_{};
  bool shared_ = false;
  AlignedNumbers path_sines_;
  std::vector<Displacement> displacements_;
  AlignedNumbers rows_, variance_, rigorous_, deviation_, scratch_;

  // For angles beyond the range of the vectorized sine: the same chains with angles reduced to one turn.
  std::vector<FoldedJoint> direct_chain_, direct_built_;
  AlignedNumbers direct_joint_, direct_built_joint_, direct_estimate_;
};

/// Largest bounds over the samples of a motion, those of the settling included, since a filter has a memory.
struct BoundsAlongPath {
  Eigen::VectorXd rigorous;  ///< of the position error
  /// Of its difference from the mean error at the centre. A filter multiplies the mean by |H(1)| and the
  /// bound of the difference by its l1 norm.
  Eigen::VectorXd deviation;

  void include(const BoundsAlongPath&);
};

/// Theory of one coordinate after one filter; the members are those of `SimulatedSignal`.
struct SignalTheory {
  double ipqn = 0, ipqn_path = 0, worst_case = 0, worst_case_path = 0;
};

/// Theory of all signals but sigma_exact.
/// @param middle   error at the centre of the motion
/// @param squares  [coordinate]: mean of sum (J C Delta)^2 over the path
/// @returns [0: the position itself, then the filters][coordinate]
std::vector<std::vector<SignalTheory>> theory_along_path(const OperationalError& middle,
                                                         const std::vector<Norms>&,
                                                         const Eigen::VectorXd& squares,
                                                         const BoundsAlongPath&);

/// Input of all runs of a simulation. Borrows its references, which must outlive it.
struct Job {
  const OperationalModel& model;
  const std::vector<Filter>& filters;
  const Motion& motion;
  const std::vector<Effect>& effects;
  const SimulationOptions& options;
  std::vector<std::uint64_t> every;  ///< [filter]: it uses every n-th sample of the motion
  std::uint64_t samples, settling, blocks;
  Eigen::VectorXd mean;     ///< of the error at the centre of the motion
  bool every_zero = false;  ///< displace the runs by equal steps over a whole count instead
};

/// Displacement of each encoder in a run by a fraction of a count, where the options ask for it: uniform, and
/// independent of all other runs, so that their scatter is that of their mean.
Eigen::VectorXd displacement_of_run(const Transmission&, const SimulationOptions&, std::uint64_t run);

/// A filter uses every n-th sample of the motion.
/// @throws Error (input; key `motion.sample_rate`) if its rate does not divide that of the motion
std::uint64_t divisor_of(const Filter&, const Motion&);

/// Result of runs that are simulated together: statistics of each, and theory at the samples of all.
struct RunsResult {
  std::vector<std::vector<RunStatistics>> outputs;  ///< [run][0: position, then the filters]
  BoundsAlongPath bounds;
  std::vector<ErrorTrace> traces;  ///< [0: position, then the filters]; of the first run alone
};

/// Simulates runs first .. first + count - 1 together, batch by batch, since all of them share the path of
/// the joints.
/// @param tick  called after every `tick_samples` of every run
RunsResult run_together(const Job&, std::uint64_t first, std::size_t count,
                        const std::function<void()>& tick);

inline constexpr std::uint64_t tick_samples = 4096;

}  // namespace qerr
