#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bound/error_ellipsoid.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"

/// Parts of the table of `analyze`.
namespace qerr {

bool has_effects(const Analysis&);

/// Unit of what a filter passes over what enters: `1/s` of a velocity, "" of a position.
std::string rate_unit(int derivative);

/// The unit of a signal, m or rad, behind a filter; "" behind a control law that states none.
std::string shown_unit(std::string_view unit, const Filter&);

/// 0 for rounding errors of sines and cosines: no length, angle or derivative of one is this small.
double cleaned(double value);

/// Ellipsoids of one sigma of the tip's position or rotation, in the axes of the analysis.
struct TipEllipsoids {
  std::string_view of, unit;  ///< `position` in m, `rotation` in rad
  ErrorEllipsoid mean;        ///< of the covariance's mean over the configurations
  ErrorEllipsoid at_largest;  ///< where the trace of the position's covariance is largest
};

/// The ellipsoids of x y z and of rx ry rz, if all three are among the coordinates.
std::vector<TipEllipsoids> tip_ellipsoids(const Analysis&);

/// Proven maxima in the report of `analyze`.

/// Adds the proofs that are asked for or required, and a warning of gaps that are wider than the one asked
/// for.
/// @throws Error (input; key `requirements`) for a required figure that is not known
void add_proofs(Analysis&, const ProofRequest&, unsigned threads);

/// The section of the table: sampled, reached and proven maximum of each figure; "" without proofs.
std::string proof_table(const Analysis&, const Style&);

}  // namespace qerr
