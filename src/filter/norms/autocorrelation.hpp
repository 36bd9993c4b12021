#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "qerr/filter/filter.hpp"

namespace qerr {

/// Autocorrelation of a filter's impulse response. For a stationary input of autocovariance c_n the output
/// has the variance r_0 c_0 + 2 sum_{n>=1} r_n c_n.
struct Autocorrelation {
  std::vector<double> r;  ///< r_n = sum_k h_k h_{k+n}, n = 0, 1, ... [1/s^(2 derivative)]
  double dc_gain = 0;     ///< H(1); H(1)^2 = r_0 + 2 sum r_n
  double tail = 0;        ///< proven bound of sum |r_n| over the truncated lags: ||h||_1 sum_{k>=N} |h_k|
};

/// The longest impulse response that is computed [samples].
inline constexpr std::size_t longest_autocorrelation = std::size_t{1} << 21;

/// The autocorrelation, truncated where the sum of the other |r_n| is below 1e-12 r_0 (more for a filter
/// whose l1 norm is known less accurately; see `tail`).
/// @throws Error (input; key `cutoff`) when the memory exceeds `longest_autocorrelation`: a cut-off below
/// about 4e-6 of the sample rate
Autocorrelation autocorrelation(const Filter&);

/// The autocorrelation; empty when the memory exceeds `longest` [samples].
std::optional<Autocorrelation> autocorrelation_within(const Filter&,
                                                      std::size_t longest = longest_autocorrelation);

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
