#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/parameter.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// Checked parameter values of one filter of the spec, by name, in SI units.
struct FilterDesign {
  int derivative = 0;
  double sample_rate = 0;                            ///< [Hz]
  std::map<std::string, double> numbers;             ///< order, cutoff [Hz], ...
  std::map<std::string, std::string> choices;        ///< discretization, ...
  std::map<std::string, std::vector<double>> lists;  ///< numerator, denominator
};

/// A row of the family list; one file of src/filter/design/families each.
struct FilterFamily {
  std::string_view name;
  std::string_view summary;
  std::vector<Parameter> parameters;
  Filter (*design)(const FilterDesign&);
  /// Orders with which robot controllers estimate velocities, by the parameters `order` and `cutoff` and the
  /// defaults of the others: `diagnose` compares recorded velocities with these. Empty: none.
  std::vector<int> velocity_orders = {};
};

/// What a family has made a filter of, so that its neighbours can be made, too.
struct FamilyDesign {
  const FilterFamily* family = nullptr;  ///< a row of `filter_families`
  FilterDesign parameters;
};

/// All families, `lowpass: {family: NAME}` in the spec, in the order of `qerr list filters`.
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
/// The coefficients are taken as exact and factored with 1024 bits into sections in w; a filter without poles
/// keeps its taps. Zeros within the rounding of the coefficients of z = 1 are moved to z = 1.
/// @param derivative  that the output estimates; adds no difference
/// @throws Error (input; key `sample_rate` or `derivative`) like `difference_filter`
/// @throws Error (input; key `numerator` or `denominator`) when empty, not finite, longer than 256 (with
/// poles), a0 = 0, or a pole is on or outside the unit circle, or within the rounding of the coefficients of
/// it
Filter filter_from_coefficients(const std::vector<double>& numerator, const std::vector<double>& denominator,
                                double sample_rate, int derivative);

}  // namespace qerr
