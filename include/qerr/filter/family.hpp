#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/parameter.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// The checked values of one filter of the spec, by parameter name.
struct FilterDesign {
  int derivative = 0;
  double sample_rate = 0;                            ///< [Hz]
  std::map<std::string, double> numbers;             ///< order, cutoff [Hz], ...
  std::map<std::string, std::string> choices;        ///< discretization, ...
  std::map<std::string, std::vector<double>> lists;  ///< numerator, denominator
};

/// A row of the family list: a name, what it is, its parameters, and the function that designs it.
struct FilterFamily {
  std::string_view name;
  std::string_view summary;
  std::vector<Parameter> parameters;
  Filter (*design)(const FilterDesign&);
};

/// All families that `lowpass: {family: NAME}` knows, in the order of `qerr list filters`.
const std::vector<FilterFamily>& filter_families();

/// The pure back differences (1 - z^-1)^d f^d, d = derivative: a filter of the spec without `lowpass`.
/// @param sample_rate  f [Hz]
/// @throws Error (input; key `sample_rate` or `derivative`) unless 0 < f < infinity and 0 <= d <=
/// max_derivative
Filter difference_filter(double sample_rate, int derivative);

/// The highest derivative that qerr estimates.
inline constexpr int max_derivative = 8;

/// A filter from coefficients in ascending powers of z^-1, normalised by a0 (contract: `numerator`,
/// `denominator`).
///
/// The coefficients are taken as exact, factored in double-double and kept as sections in w; a filter without
/// poles keeps its taps. Zeros at z = 1 that differ from it by the rounding of the coefficients only are put
/// there.
/// @param derivative  what the output estimates; adds no difference
/// @throws Error (input; key `numerator` or `denominator`) when empty, not finite, longer than 256 (with
/// poles), a0 = 0, or a
///         pole is on or outside the unit circle, or nearer to it than the rounding of the coefficients can
///         tell
Filter filter_from_coefficients(const std::vector<double>& numerator, const std::vector<double>& denominator,
                                double sample_rate, int derivative);

}  // namespace qerr
