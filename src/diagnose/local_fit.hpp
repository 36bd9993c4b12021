#pragma once

#include <Eigen/Core>

namespace qerr {

/// Local fits of a record whose stamps are uneven.
struct LocalFit {
  Eigen::ArrayXd value, slope;  ///< in the middle of the window [unit], [unit/s]
  double kept = 0;              ///< of white noise' variance in record - value
};

/// Whether intervals differ from their mean by more than a twentieth: stamps that were rounded do not.
bool is_uneven(const Eigen::ArrayXd& time);

/// A cubic (through three points: a line) by least squares through the 2 h + 1 points about each one, at
/// their own stamps. Near the ends the window reaches only inwards.
LocalFit local_fit(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x, Eigen::Index h);

/// What four neighbours, at their own stamps, say of each point: the part of the record that no cubic has, to
/// the scale of white noise. Rows 2 .. n - 3.
Eigen::ArrayXd roughness_at(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x);

}  // namespace qerr
