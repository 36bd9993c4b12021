#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "diagnose/search/error_model.hpp"

namespace qerr {

/// Families of the chosen terms that the quantizer alone would bring: the fit without the term, sent through
/// the quantizer along the same path with new noise, is analysed with it. Its decrease of the sum of squares
/// is compared with the mean decrease in nine such simulations (F test, error rate 1 %).
std::vector<std::string> brought_by_rounding(const ErrorModel&, const Choice&, std::uint64_t seed);

}  // namespace qerr
