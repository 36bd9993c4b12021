#pragma once

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
/// @pre the filter has settled: a mean that is switched on passes with partial sums of h, not with H(1);
///   the Jacobian is constant over the filter's memory; sigma also needs white input, false below about
/// one count
///   a sample
Bounds derivative_error(double half_width, double mean, double sigma, const Norms& norms);

}  // namespace qerr
