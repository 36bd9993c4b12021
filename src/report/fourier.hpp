#pragma once

#include <complex>
#include <vector>

namespace qerr {

/// sum_k values[k] e^{-2 pi i n k / N} for n = 0 .. N/2, N the number of values.
/// @pre N is even
std::vector<std::complex<double>> half_spectrum(const std::vector<double>& values);

}  // namespace qerr
