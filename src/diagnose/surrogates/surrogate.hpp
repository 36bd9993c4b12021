#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "diagnose/record/evidence.hpp"
#include "diagnose/surrogates/residual_kernels.hpp"
#include "lanes/aligned.hpp"

namespace qerr {

/// Rows of a record that follow each other.
struct Stretch {
  Eigen::Index first = 0, rows = 0;
};

/// At most about `most` rows in 16 stretches that are spread over the record evenly; all rows when there are
/// fewer.
std::vector<Stretch> stretches(Eigen::Index rows, Eigen::Index most);

/// What an ideal encoder would have read along the path of a record: what is the same for every surrogate.
///
/// residual = Q(x + phase) - phase - reference. The reference is what it is, and the true position x under it
/// is drawn: the path, plus what smoothing may have left in it of the reference's noise, with the variance
/// that smoothing keeps and all of the noise's slow part. So reference - x has the noise of the reference,
/// whatever its course, and what smoothing bent is found in the surrogates as in the record. While a joint
/// rests, its position is one, known to the noise of the mean. The phase is uniform over a count where the
/// encoder's zero is free, and nought where it is known: its edges then lie where they lie.
struct SurrogatePlan {
  std::vector<SurrogateRow> rows;  ///< of all stretches, one behind the other
  PathNoise noise;
  bool zero_known;
};

SurrogatePlan surrogate_plan(const Evidence&, const std::vector<Stretch>&);

/// Surrogates side by side, drawn anew: lanes first .. first + width - 1 of a seed. A lane is the same
/// whatever else is drawn.
class Surrogates {
 public:
  /// @param width  a multiple of 8
  Surrogates(const SurrogatePlan&, std::uint64_t seed, std::uint64_t first, std::size_t width,
             InstructionSet);

  /// To the beginning of a stretch.
  void start();

  /// The next rows, from `row` of the plan on: residuals [counts], and the readings' counts modulo four.
  /// @param residual, state  [row][lane], aligned to 64 bytes
  void read(std::size_t row, std::size_t rows, double* residual, double* state);

 private:
  SurrogateLanes lanes();

  const SurrogatePlan& plan_;
  const ResidualKernels& kernels_;
  std::size_t width_;
  std::vector<std::uint64_t> generator_;
  AlignedNumbers phase_, first_, second_, level_;
};

}  // namespace qerr
