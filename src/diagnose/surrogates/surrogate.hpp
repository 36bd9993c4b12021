#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "diagnose/record/evidence.hpp"
#include "diagnose/surrogates/residual_kernels.hpp"
#include "lanes/aligned.hpp"

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

}  // namespace qerr
