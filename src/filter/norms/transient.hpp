#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "qerr/filter/filter.hpp"

namespace qerr {

/// Sigma of the output over sigma of a white input, k = 0 .. count-1 samples after switching on
/// [1/s^derivative].
///
/// The recursion of the state's covariance from zero (paper, Eqs. 31 to 35 and 38; y_k = C x_k + D e_k, the
/// index of Eq. 30 corrected) sums to sigma_k^2 = sum_{i<=k} h_i^2: it never falls, and tends to ||H||_2. The
/// input must be white, not only zero mean: that is what removes the cross terms between Eqs. 34 and 35.
/// @param every  of a slow filter only samples 0, every, 2 every, ...
std::vector<double> noise_transient(const Filter&, std::size_t count, std::size_t every = 1);

/// Time after switching on at which sigma reaches the fraction of ||H||_2 [s]; empty when that takes more
/// than 2^22 samples.
/// @pre 0 <= fraction < 1
std::optional<double> noise_rise_time(const Filter&, double fraction = 0.99);

}  // namespace qerr
