#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

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

  /// @param variance  that theory expects here of the first channels, up to a factor
  void add(const Eigen::ArrayXd& values, const Eigen::ArrayXd& variance, std::uint64_t block);

  /// Adds the blocks of a later run.
  void append(const RunStatistics& later);

  double mean(Eigen::Index channel) const;
  double variance(Eigen::Index channel) const;  ///< about the mean of all
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
  Eigen::ArrayXd peak_;
};

}  // namespace qerr
