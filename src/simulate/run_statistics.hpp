#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "kernels.hpp"

namespace qerr {

/// Mean, variance and peak of many channels, and how far the variance of the first ones scatters between
/// blocks of the record: that gives the interval of sigma without a word about the error's spectrum.
class RunStatistics {
 public:
  struct Interval {
    double lower = 0, upper = 0;
  };

  /// @param expected  of the channels, the first ones: how many have a variance that is known in shape
  RunStatistics(Eigen::Index channels, Eigen::Index expected, std::uint64_t blocks);

  /// Rows of channels, `stride` numbers apart; all of one block.
  ///
  /// Squares are summed up about the first row, which is no farther from the mean than the root of their
  /// number times the deviation: whatever the mean, 2 digits are lost at most.
  /// @param rows      at most batch_size, and at least 1
  /// @param width     of a row: the channels, filled up to whole lanes
  /// @param room      4 width numbers, aligned to 64 bytes
  void add(const double* values, std::size_t stride, std::size_t rows, std::size_t width, std::uint64_t block,
           const SimulationKernels&, double* room);

  /// @param variance  sum of what theory expects of the first channels in some rows of a block, up to a
  /// factor
  void expect(const Eigen::Ref<const Eigen::ArrayXd>& variance, std::uint64_t block) {
    blocks_[block].expected += variance;
  }

  /// Adds the blocks of a later run.
  void append(const RunStatistics& later);

  double mean(Eigen::Index channel) const;
  double variance(Eigen::Index channel) const;  ///< about the mean of all
  /// Of one of the first channels.
  double peak(Eigen::Index channel) const { return peak_[channel]; }

  /// 95 % interval of sigma: Student's t over the blocks' mean squares, of which what theory expects to vary
  /// from block to block is no uncertainty (a ratio estimator).
  Interval sigma_interval(Eigen::Index channel) const;

 private:
  struct Sums {
    double count = 0;
    Eigen::ArrayXd mean, squares, expected;  ///< squares about the mean: no digits are lost to a large one

    void join(const Sums& other);
  };
  void join_neighbours();

  std::vector<Sums> blocks_;
  Eigen::ArrayXd peak_;  // of the channels whose variance is known in shape
};

}  // namespace qerr
