#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "diagnose/record/evidence.hpp"
#include "effect/term.hpp"

namespace qerr {

/// First rows of the blocks of a record for cross-validation and block bootstrap. A block is long compared
/// with the correlation of neighbouring rows: at least 50 rows and, if the record is long enough, one
/// revolution of the encoder's shaft or the motion between two reversals. A record of 400 or more rows has 8
/// to 128 blocks.
std::vector<Eigen::Index> block_starts(const Evidence&);

/// A record, or a term of it, restricted to some rows.
Evidence rows_of(const Evidence&, const std::vector<Eigen::Index>& rows);
Term rows_of(const Term&, const std::vector<Eigen::Index>& rows);

/// Some rows of a record, averaged in groups.
///
/// Signals that depend on the history of the motion (hysteresis, relaxation) are computed over the whole
/// record and then averaged; all others are computed from the averaged signals.
struct Sampling {
  const Evidence* record = nullptr;  ///< must outlive the sampling
  std::vector<RowGroup> groups;
  Evidence evidence;  ///< signals averaged over the groups

  Sampling(const Evidence& record, std::vector<RowGroup> groups);

  /// Averages over the groups of a column over the rows of the record.
  Eigen::ArrayXd averaged(const Eigen::ArrayXd& column) const;

  /// Averages over the groups of a value that `of_row` computes at each row.
  template <class OfRow>
  Eigen::ArrayXd averaged_rows(OfRow of_row) const {
    Eigen::ArrayXd out = Eigen::ArrayXd::Zero(static_cast<Eigen::Index>(groups.size()));
    for (std::size_t g = 0; g < groups.size(); ++g) {
      double& mean = out[static_cast<Eigen::Index>(g)];
      for (Eigen::Index k = groups[g].first; k < groups[g].end; ++k) mean += of_row(k);
      mean /= static_cast<double>(groups[g].end - groups[g].first);
    }
    return out;
  }
};

/// Samples of an encoder's error for a linear regression.
///
/// Where the count changes by one from one row to the next, an edge was crossed in between, whose position is
/// known: the mean reading of the two rows less their mean position is free of quantization. What remains is
/// where between the two rows the edge was crossed, uniform over the motion of v counts: variance v^2/12
/// [counts^2]. In faster motion every row is a sample, and at rest every reading, with the quantization error
/// itself, 1/12.
struct ErrorSamples {
  Sampling sampling;
  Eigen::ArrayXd error;     ///< encoder - path, less the mean of the rounding [rad or m]
  Eigen::ArrayXd variance;  ///< of quantization, residual noise of the path and random effects of the spec
  /// What the residual noise of the path adds to the variance of a sum of neighbouring samples beyond that of
  /// independent ones, per sample: smoothing lowers the variance of a row by sharing it among rows, and what
  /// is slow has the noise of the reference as it was before. See shared_rows.
  Eigen::ArrayXd shared;

  Eigen::Index size() const { return error.size(); }
};

/// A search for causes needs more samples than the fewest terms have coefficients, and is not made better by
/// more than the most.
inline constexpr Eigen::Index fewest_samples = 8, most_samples = 6000;

/// @param most  limit of the number of samples: beyond it one is drawn from each of `most` equal sections
ErrorSamples error_samples(const Evidence& record, std::uint64_t seed, Eigen::Index most);

}  // namespace qerr
