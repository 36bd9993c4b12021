#pragma once

#include <complex>
#include <vector>

#include "qerr/filter/filter.hpp"

namespace qerr {

/// Poles and zeros of a filter's sections in w, both of each pair.
struct Corners {
  std::vector<std::complex<double>> zeros, poles;
  double slowest_pole = 1;  ///< smallest |w|, at most 1
};

Corners corners(const Filter&);

/// The limit of H/(j 2 pi f)^derivative at 0 Hz, with its sign: 1 for a filter that estimates its derivative,
/// infinite for one that passes a lower derivative, 0 for one that passes only higher ones.
///
/// Zeros 1e12 times slower than the slowest pole count as zeros at 0 Hz.
double limit_at_dc(const Filter&);

}  // namespace qerr
