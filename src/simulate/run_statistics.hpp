#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lanes/batch.hpp"
#include "simulate/kernels.hpp"

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
  /// Of one of the first channels: mean of the variances that theory expects.
  double expected(Eigen::Index channel) const;
  /// Of one of the first channels.
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

}  // namespace qerr
