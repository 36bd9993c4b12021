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

/// A matrix by rows; a list has rows of one number, a number is one row of one.
using Rows = std::vector<std::vector<double>>;

/// How the spec states an existing filter in place of `lowpass`: a row of the list of representations; one
/// file of src/filter/design/representations each.
struct FilterRepresentation {
  std::string_view name;
  std::string_view summary;
  Parameter key;                  ///< of the filter in the spec; selects the representation
  std::vector<Parameter> inside;  ///< keys of the mapping at `key`; empty where `key` itself has the numbers
  std::vector<Parameter> beside;  ///< further keys of the filter that go with `key`
  /// @param values  of `key` or of the keys inside it, and of those beside it, by name
  /// @param derivative  that the output estimates; adds no difference
  /// @throws Error (input; a key, or `key[index]` of a list)
  Filter (*build)(const std::map<std::string, Rows>& values, double sample_rate, int derivative);
};

/// All representations, in the order of `qerr list filters`.
const std::vector<FilterRepresentation>& filter_representations();

/// Second-order sections [b0, b1, b2, a0, a1, a2] in ascending powers of z^-1 (scipy, with any a0).
///
/// The coefficients are taken as exact. `Filter::deviation` bounds the rounding of their sums in w. A
/// numerator whose sum is 0 within the rounding of its coefficients gets a zero at z = 1.
/// @throws Error (input; key `sos` or `sos[i]`) when there are none or over 50, a row has not six finite
/// numbers, a0 = 0, or a pole is on or outside the unit circle, or within the rounding of the
/// coefficients of it
Filter filter_from_sections(const Rows& sos, double sample_rate, int derivative);

/// gain prod(z - zero)/prod(z - pole); each zero and pole a row [re] or [re, im], complex ones in conjugate
/// pairs.
/// @throws Error (input; key `zeros`, `poles` or `gain`, with an index) when a row has another size, a
/// conjugate is missing, there are more zeros than poles, over 100 poles, or a pole is on or outside the unit
/// circle
Filter filter_from_zeros_and_poles(const Rows& zeros, const Rows& poles, double gain, double sample_rate,
                                   int derivative);

/// x_(k+1) = A x_k + B u_k, y_k = C x_k + D u_k: H = D + C (z I - A)^-1 B, single input, single output.
///
/// The matrices are taken as exact. The transfer function (Faddeev and Le Verrier), its transformation to w
/// and its roots are computed with 1024 bits. H(1) = D + C (I - A)^-1 B is set to 0 if it is 0 within
/// rounding.
/// @param b, c  a column or a row, one number per row of A
/// @throws Error (input; key `A`, `B`, `C` or `D`) when a shape is wrong, a number is not finite, A has over
/// 20 rows, or an eigenvalue of A is on or outside the unit circle, or within the rounding of A of it
Filter filter_from_state_space(const Rows& a, const Rows& b, const Rows& c, const Rows& d, double sample_rate,
                               int derivative);

}  // namespace qerr
