#pragma once

#include "qerr/bound/operational_error.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

/// Bounds of one signal: its worst case and its standard deviation.
struct Bounds {
  double worst_case = 0;
  double sigma = 0;
};

/// Error of a filtered derivative, given the error of its input coordinate (paper, Eqs. 26 and 28).
///
/// |y| <= ||H||_1 half_width + |H(1)| |mean|, and for white x: sigma_y = ||H||_2 sigma_x.
/// @param half_width  of the operational coordinate's error about its mean [m or rad]
/// @param mean        of that error; 0 unless an encoder rounds down
/// @param sigma       of that error
/// @param norms       of the derivative filter [1/s for a velocity]
/// @returns bounds of the derivative [m/s or rad/s]
/// @pre steady state of the filter (the response to a mean that is switched on is a partial sum of h, not
/// H(1));
///   the Jacobian is constant over the filter's memory; sigma also needs white input, which is false below
///   about one count per sample
Bounds derivative_error(double half_width, double mean, double sigma, const Norms& norms);

/// Bounds of the filtered error for a coordinate of an OperationalError with error sources: their half widths
/// are multiplied by
/// ||H||_1 and their means by |H(1)| as well, the sigma of each by its own ratio, which depends on the
/// spectrum of the source.
/// @param ratios  of `sigma_ratios`, one per source; empty without sources
Bounds derivative_error(const OperationalError&, Eigen::Index coordinate, const Norms&,
                        const Eigen::VectorXd& ratios);

}  // namespace qerr
