#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "diagnose/record/evidence.hpp"
#include "diagnose/surrogates/residual_kernels.hpp"
#include "lanes/batch.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// Consecutive rows of a record.
struct RowRange {
  Eigen::Index first = 0, rows = 0;
};

/// About `most` rows in 16 ranges that are evenly spread over the record, or all rows if there are fewer.
std::vector<RowRange> sampled_ranges(Eigen::Index rows, Eigen::Index most);

/// Readings of an ideal encoder along the path of a record: the data that all surrogates share.
///
/// residual = Q(x + phase) - phase - reference, Q the quantizer. The reference is that of the record; the
/// true position x is drawn at random: the path, plus noise with the variance that remains after smoothing,
/// plus the slow part of what smoothing removed. Thus reference - x has the noise of the reference, and a
/// distortion by smoothing is the same in the surrogates and in the record. At standstill the position is
/// constant, with the standard error of the mean. The phase is uniform over a count if the encoder's zero is
/// free, and 0 if it is known.
struct SurrogatePlan {
  std::vector<SurrogateRow> rows;  ///< of all ranges
  PathNoise noise;
  bool zero_known;
};

SurrogatePlan surrogate_plan(const Evidence&, const std::vector<RowRange>&);

/// Surrogates first .. first + width - 1 of a seed, one per lane. A surrogate does not depend on `first` and
/// `width`. The plan must outlive this object.
class Surrogates {
 public:
  /// @param width  a multiple of 8
  Surrogates(const SurrogatePlan&, std::uint64_t seed, std::uint64_t first, std::size_t width,
             InstructionSet);
  Surrogates(const Surrogates&) = delete;
  Surrogates& operator=(const Surrogates&) = delete;

  /// Starts a new range.
  void start();

  /// Computes rows from `row` of the plan on: residuals [counts], and the counts modulo four.
  /// @param residual, state  [row][lane], aligned to 64 bytes
  void read(std::size_t row, std::size_t rows, double* residual, double* state);

 private:
  SurrogateLanes lanes();

  const SurrogatePlan& plan_;
  const ResidualKernels& kernels_;
  std::size_t width_;
  std::vector<std::uint64_t> generator_;
  AlignedNumbers phase_, first_, second_, standstill_;
};

/// Distribution of a statistic under the hypothesis that the model is right.
enum class Tail {
  both_sides,  ///< nearly normal about its mean
  chi_squared  ///< a norm: its square is a sum of `degrees` squares
};

/// A statistic of one encoder's residual, of the record and of every surrogate.
struct ResidualStatistic {
  std::string name;
  Tail tail = Tail::both_sides;
  int degrees = 1;
  /// Lower bound of the standard deviation that is assumed: the accuracy of the smoothed path (convention).
  double least = 0.01;
  Eigen::ArrayXd values;  ///< of the record, then of every surrogate
};

/// Statistics of measured - reference, in counts (ratios and correlations without unit):
///
/// - mean (if the encoder's zero is known; else the mean is subtracted before all other statistics);
/// - sigma_ratio, to Delta/sqrt 12;
/// - uniformity, the largest distance of the distribution function from that of the quantization error
///   (Kolmogorov);
/// - autocorrelation, of neighbouring readings, and autocorrelation_smooth, of means over 16;
/// - by_direction, by_time (difference of the means of both directions, of both halves), by_speed, by_effort
///   (rms of the part proportional to them), by_angle (amplitude of the encoder shaft's first order),
///   by_count (rms of the means of the four quadrature states);
/// - velocity_sigma of each filter of the spec for the first derivative, relative to Delta ||H||_2/sqrt 12,
///   if the record has even stamps at its rate.
/// @param surrogates  number of surrogates
std::vector<ResidualStatistic> residual_statistics(const Evidence&, const std::vector<Filter>&,
                                                   Eigen::Index surrogates, std::uint64_t seed,
                                                   unsigned threads, InstructionSet = instruction_set());

}  // namespace qerr
