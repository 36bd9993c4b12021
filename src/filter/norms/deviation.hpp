#pragma once

#include <optional>
#include <vector>

#include "filter/norms/ball.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// Proven bounds of ||b/a - H|| for the filter H that was computed from the coefficients b, a (ascending in
/// z^-1, taken as exact); empty unless both are proven stable.
/// @param modulus  largest pole modulus, approximately
std::optional<Deviation> deviation_of(const Filter& h, const std::vector<double>& b,
                                      const std::vector<double>& a, double modulus);
std::optional<Deviation> deviation_of(const Filter& h, const std::vector<Binary1024>& b,
                                      const std::vector<Binary1024>& a, double modulus);

}  // namespace qerr
