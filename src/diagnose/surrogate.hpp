#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "qerr/diagnose/evidence.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// Rows of a record that follow each other.
struct Stretch {
  Eigen::Index first = 0, rows = 0;
};

/// At most about `most` rows in 16 stretches that are spread over the record evenly; all rows when there are
/// fewer.
std::vector<Stretch> stretches(Eigen::Index rows, Eigen::Index most);

/// What an ideal encoder would have read along the path of a record, drawn anew for several lanes at once.
///
/// residual = Q(x + phase) - phase - reference. The reference is what it is, and the true position x under it
/// is drawn: the path, plus what smoothing may have left in it of the reference's noise, with the variance
/// that smoothing keeps and all of the noise's slow part. So reference - x has the noise of the reference,
/// whatever its course, and what smoothing bent is found in the surrogates as in the record. While a joint
/// rests, its position is one, known to the noise of the mean. The phase is uniform over a count where the
/// encoder's zero is free, and nought where it is known: its edges then lie where they lie.
class Surrogate {
 public:
  /// @param lane  of the first; lane i of a seed is the same whatever else is drawn
  Surrogate(const Evidence&, std::uint64_t seed, std::uint64_t lane, Eigen::Index lanes);

  /// To the beginning of a stretch.
  void start();

  /// The next row: residual [counts] of every lane, and the reading's count modulo four.
  void read(Eigen::Index row, Eigen::ArrayXd& residual, Eigen::ArrayXi& state);

 private:
  void draw_numbers();
  void draw();
  void find_rests(double part);

  const Evidence& e_;
  double noise_, below_;  // [counts]
  Eigen::ArrayXd path_;   // [counts]
  Eigen::ArrayXi rest_;   // readings of the rest that a row is in, 0 in motion
  double pole_;           // of the two low-passes that make what smoothing left
  std::vector<std::uint64_t> state_;
  Eigen::ArrayXd phase_, first_, second_, drawn_, level_, x_;
  Eigen::Index resting_ = 0;  // the same, of the row before
};

}  // namespace qerr
