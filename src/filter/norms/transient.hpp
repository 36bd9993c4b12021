#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "qerr/filter/filter.hpp"

namespace qerr {

/// Sigma of the output over sigma of a white input, k = 0 .. count-1 samples after the input starts
/// [1/s^derivative].
///
/// The recursion of the state's covariance from zero (paper, Eqs. 31 to 35 and 38; y_k = C x_k + D e_k, the
/// index of Eq. 30 corrected) gives sigma_k^2 = sum_{i<=k} h_i^2, which increases to ||H||_2. The
/// input must be white, not only of zero mean: only then the cross terms between Eqs. 34 and 35 vanish.
/// @param every  above 1 only samples 0, every, 2 every, ..., in double precision: for slow filters
std::vector<double> noise_transient(const Filter&, std::size_t count, std::size_t every = 1);

/// Time after the input starts at which sigma reaches the fraction of ||H||_2 [s]; empty above 2^22 samples.
/// @pre 0 <= fraction < 1
std::optional<double> noise_rise_time(const Filter&, double fraction = 0.99);

}  // namespace qerr
