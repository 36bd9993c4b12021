#pragma once

#include <cstdint>
#include <vector>

#include "diagnose/inference/explanation.hpp"
#include "qerr/diagnose/diagnosis.hpp"

namespace qerr {

/// Cross-validated residual of one encoder with and without an explanation.
///
/// Two folds of alternating blocks: the terms are fitted to the even blocks and evaluated on the odd ones,
/// and vice versa. The residual is measured - reference, including its mean and the quantization; of an
/// encoder with a free zero, less a fitted constant.
struct HeldOut {
  struct Block {
    double before = 0, after = 0, rows = 0;  ///< sums of squares [rad^2 or m^2]
  };
  std::vector<Block> blocks;
  double step = 0;  ///< of the encoder [rad or m]
  bool prismatic = false;
  bool held_out = true;  ///< false: the record is too short to be divided, and `after` is of the fit itself
  double readings = 0;   ///< number of independent readings, over which the figures below are sums
  double residual = 0;   ///< squares of the extended model's residual, in counts
  double predicted = 0;  ///< the same of quantization, stated noise and the scatter found: no part is fitted
  double log_score = 0;  ///< log-likelihood gained against the model without terms
  double inside = 0;     ///< readings within the model's central 95 %
};

/// @param record   all rows
/// @param sampled  the independent rows among them, `groups` that each one represents
/// @param terms    over the rows of `sampled`, whose coefficients are fitted to one half of them at a time
HeldOut hold_out(const Evidence& record, const Evidence& sampled, const std::vector<RowGroup>& groups,
                 const std::vector<Term>& terms);

/// Sum of the squares of reading - position that quantization and noise of a variance in each row make
/// [counts^2].
/// @param added     to the path, by the model [rad or m]
/// @param variance  of the noise [rad^2 or m^2], > 0
double expected_squares(const Evidence&, const Eigen::ArrayXd& added, const Eigen::ArrayXd& variance);

/// The gain over all rows of some encoders, with the 95 % interval of its ratio by drawing blocks with
/// replacement (bootstrap).
Gain gain(const std::vector<HeldOut>&, std::uint64_t seed);

}  // namespace qerr
