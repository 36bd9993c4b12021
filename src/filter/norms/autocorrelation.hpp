#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "qerr/filter/filter.hpp"

namespace qerr {

/// What a filter does to the power of any stationary input: the autocorrelation of its impulse response.
///
/// For an input of covariance c_n the output has the variance r_0 c_0 + 2 sum_{n>=1} r_n c_n.
struct Autocorrelation {
  std::vector<double> r;  ///< r_n = sum_k h_k h_{k+n}, n = 0, 1, ... [1/s^(2 derivative)]
  double dc_gain = 0;     ///< H(1); H(1)^2 = r_0 + 2 sum r_n
  double tail = 0;        ///< proven bound of sum |r_n| over the lags left out: ||h||_1 sum_{k>=N} |h_k|
};

/// The longest memory that is followed [samples].
inline constexpr std::size_t longest_autocorrelation = std::size_t{1} << 21;

/// The autocorrelation down to lags that together matter less than 1e-12 of r_0 (or, in a filter whose l1
/// norm is only known less exactly, as little as that allows; see `tail`).
/// @throws Error (input; key `cutoff`) when the memory exceeds `longest_autocorrelation`: a cut-off below
/// about 4e-6 of the sample rate
Autocorrelation autocorrelation(const Filter&);

/// The same, empty instead of that error.
/// @param longest  memory that is followed [samples]
std::optional<Autocorrelation> followed(const Filter&, std::size_t longest = longest_autocorrelation);

}  // namespace qerr
