#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lanes/aligned.hpp"
#include "simulate/kernels.hpp"

namespace qerr {

/// Mean, variance and peak of many channels, and how far the variance of the first ones scatters between
/// blocks of the record: that gives the interval of sigma without a word about the error's spectrum.
///
/// Samples come in the order of time. Squares are summed up about the first value of a piece of them, which
/// is no farther from the mean than the root of their number times the deviation: whatever the mean, 4 digits
/// are lost at most, and none where the first value is like the others.
class RunStatistics {
 public:
  struct Interval {
    double lower = 0, upper = 0;
  };

  /// @param expected  of the channels, the first ones: how many have a variance that is known in shape, and a
  /// peak that is asked for
  /// @param width     of a row: the channels, filled up to whole lanes
  RunStatistics(Eigen::Index channels, Eigen::Index expected, std::size_t width, std::uint64_t blocks,
                const SimulationKernels&);

  /// Rows of channels, `stride` numbers apart; all of one block.
  void add(const double* values, std::size_t stride, std::size_t rows, std::uint64_t block);

  /// Where a kernel is to add `instants` instants of one block in lanes.
  struct Place {
    const ChannelTally* tally;
    bool fresh;
  };
  Place place(std::size_t instants, std::uint64_t block);
  /// Where a kernel is to add `rows` rows of one block.
  /// @param gain  what all rows are to be multiplied with, the same at every call
  Place place_of_rows(std::size_t rows, std::uint64_t block, double gain);

  /// @param variance  sum of what theory expects of one of the first channels in some rows of a block, up to
  /// a factor
  void expect(Eigen::Index channel, double variance, std::uint64_t block) {
    blocks_[block].expected[channel] += variance;
  }

  /// No sample follows: what has been added enters the figures.
  void finish();

  /// Adds the blocks of a later run; both are finished.
  void append(const RunStatistics& later);

  double mean(Eigen::Index channel) const;
  double variance(Eigen::Index channel) const;  ///< about the mean of all
  /// Of one of the first channels.
  double peak(Eigen::Index channel) const { return peak_[channel]; }
  /// How many channels have one.
  std::size_t peaks() const { return static_cast<std::size_t>(peak_.size()); }

  /// 95 % interval of sigma: Student's t over the blocks' mean squares, of which what theory expects to vary
  /// from block to block is no uncertainty (a ratio estimator).
  Interval sigma_interval(Eigen::Index channel) const;

 private:
  struct Sums {
    double count = 0;
    Eigen::ArrayXd mean, squares, expected;  ///< squares about the mean: no digits are lost to a large one

    void join(double other_count, Eigen::Index channel, double other_mean, double other_squares);
    void join(const Sums& other);
  };
  /// Samples of one block that are summed up about the same values.
  struct Piece {
    std::size_t lanes = 1;  // sums of each channel
    std::size_t count = 0;
    std::uint64_t block = 0;
    AlignedNumbers numbers;
    ChannelTally tally{};
  };
  Piece piece(std::size_t width, std::size_t lanes) const;
  bool extend(Piece&, std::size_t count, std::uint64_t block);
  void close(Piece&, double gain);
  void join_neighbours();

  std::vector<Sums> blocks_;
  Eigen::ArrayXd peak_;  // of the channels whose variance is known in shape
  std::size_t width_;
  const SimulationKernels* kernels_;
  double gain_ = 1;  // of the rows
  Piece rows_, instants_;
};

}  // namespace qerr
