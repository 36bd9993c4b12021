#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "bound/error_ellipsoid.hpp"
#include "qerr/report/analysis.hpp"

namespace qerr {

/// Ellipsoids of one sigma of the tip's position or rotation, in the axes of the analysis.
struct TipEllipsoids {
  std::string_view of, unit;  ///< `position` in m, `rotation` in rad
  ErrorEllipsoid mean;        ///< of the covariance's mean over the configurations
  ErrorEllipsoid at_largest;  ///< where the trace of the position's covariance is largest
};

/// The ellipsoids of x y z and of rx ry rz, if all three are among the coordinates.
std::vector<TipEllipsoids> tip_ellipsoids(const Analysis&);

}  // namespace qerr
