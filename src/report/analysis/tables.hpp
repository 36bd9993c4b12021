#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bound/error_ellipsoid.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"

/// Parts of the table of `analyze`.
namespace qerr {

/// Every encoder with its share as a bar; the largest is marked.
std::string encoder_table(const Analysis&, const Style&);

/// Median and maximum of every signal: one row a coordinate, one block a signal.
std::string summary_table(const Analysis&, const Style&);

/// All statistics that tables show, one table a signal.
std::string detail_tables(const Analysis&, const Style&);

/// Of every encoder, what its resolution and its accuracy contribute to the tip's variance; "" if no encoder
/// states an accuracy.
std::string accuracy_table(const Analysis&, const Style&);

/// The ellipsoids of one sigma, in the axes of the analysis; "" without three coordinates of a kind.
std::string ellipsoid_tables(const Analysis&, const Style&);

/// Shares of the configurations above the limits that were asked for, by the distance of the tip.
std::string exceedance_tables(const Analysis&, const Style&);

bool has_effects(const Analysis&);

/// Unit of what a filter passes over what enters: `1/s` of a velocity, "" of a position.
std::string rate_unit(int derivative);

/// `H2 norm 40.738/s, l1 norm 138.86/s, 1.00 ms a sample`.
std::string norm_text(const NamedFilter&);

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
