#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "effect/term.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

// The columns of a log are joint coordinates; with a coupling the coordinate of an encoder is a combination
// of several joints.

/// Log resolution of a column; 0 if it never changes: "0" may be any value that rounds to it.
double resolution_of(const Log&, Eigen::Index column);

/// Whether the encoder's coordinate depends on its own joint only.
bool depends_on_one_joint(const OperationalModel&, Eigen::Index encoder);

/// Reference of the encoder's coordinate, combined from the references of all joints that it depends on.
struct EncoderReference {
  Eigen::ArrayXd position;    ///< [rad or m]; empty if a joint's reference is missing
  double log_resolution = 0;  ///< coarsest step of these columns in the file [rad or m]
  double noise = 0;  ///< of those that are interpolated between samples, see noise_between [rad or m]
};
EncoderReference encoder_reference(const OperationalModel&, const Log&, Eigen::Index encoder);
bool has_reference(const OperationalModel&, const Log&, Eigen::Index encoder);

/// The encoder's coordinate combined from the measured positions of these joints (measured_joint) [rad or m];
/// empty if one of them is missing.
Eigen::ArrayXd encoder_measured(const OperationalModel&, const Log&, Eigen::Index encoder);

/// One encoder's measurements and reference, in the encoder's coordinate (at the joint's side of its gear).
struct Evidence : RecordSignals {
  Eigen::Index number = 0;      ///< of the encoder
  Eigen::ArrayXd reference;     ///< of the reference sensor [rad or m]
  Eigen::ArrayXd random_sigma;  ///< standard deviation of the spec's random effects [rad or m]; empty: none
  double noise = 0;             ///< standard deviation of the reference's noise [rad or m]
  double path_noise = 0;        ///< standard deviation of the noise that remains in the path [rad or m]
  double log_resolution = 0;    ///< step of the recorded reference [rad or m]
  double interval = 0;          ///< of the rows as recorded, in the mean [s]; 0: not ordered
  bool repeated = false;        ///< most rows are of the pose of the row before them, with the same reading
  /// The other encoders at the same rows, which outlive it; of a part of the rows they are those of the
  /// whole.
  std::vector<const Evidence*> others;
};

/// Everything that an evidence has row by row; some of it may be empty.
std::vector<Eigen::ArrayXd*> series_of(Evidence&);

/// Recorded rows that share the residual noise of a smoothed path: its integrated autocorrelation. Smoothing
/// of white noise by weights of sum 1 keeps the power at frequency zero, so that it is the ratio of the
/// variances before and after.
double shared_rows(const Evidence&);

/// The path with as little of the reference's noise as the record allows (sectioned_path). Readings of a path
/// with noise have the first harmonic of their rounding lowered by exp(-2 pi^2 sigma^2), and rows that noise
/// has set apart have more of it than others: below 0.05 counts, 5 %, it is the path itself.
Eigen::ArrayXd path_without_noise(const Evidence&);

/// Consecutive rows [first, end).
struct RowGroup {
  Eigen::Index first, end;
};

/// Groups of rows with the same reading and true position. At standstill only the reference's noise changes:
/// rows of a group are not independent readings, and treating them as such would multiply the evidence of one
/// coincidence.
/// @param most  limit of the number of groups, so that the time of a fit does not grow with the record;
///   beyond it, one group is drawn by the seed from each of `most` equal sections
std::vector<RowGroup> independent_rows(const Evidence&, std::uint64_t seed, Eigen::Index most = 16384);

/// One group drawn by the seed from each of `most` equal sections; all of them where they are no more.
std::vector<RowGroup> drawn(const std::vector<RowGroup>&, std::uint64_t seed, Eigen::Index most);

/// The evidence with the mean of each group in place of its rows.
Evidence group_means(const Evidence&, const std::vector<RowGroup>&);

/// Whether the rows are poses and not samples of a motion: from row to row the joint moves by more than 3 %
/// of its range and three counts, that is, a period of its motion has fewer than 64 rows, and consecutive
/// moves have nothing in common. Those of a path are nearly equal; those of random poses have a correlation
/// of -1/2.
/// @param step  resolution of the encoder [unit of the reference]
bool is_static(const Eigen::ArrayXd& reference, double step);

/// The evidence of those of the encoders whose joints have a reference.
/// @param log  with its values
std::vector<Evidence> evidence(const OperationalModel&, const Log& log,
                               const std::vector<std::size_t>& encoders, unsigned threads = 0);

/// The numbers of all encoders.
std::vector<std::size_t> all_encoders(const OperationalModel&);

/// A record of more than 2^16 rows becomes one row, drawn by the seed, from each of as many equal sections:
/// the search and the fits use fewer. Rows at random times have no aliases.
Evidence thinned(Evidence, std::uint64_t seed);

}  // namespace qerr
