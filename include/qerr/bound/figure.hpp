#pragma once

#include <compare>
#include <cstddef>
#include <span>
#include <string_view>

namespace qerr {

/// What is told of an error. Of the position: the first three; behind a filter: the first, and the last
/// three.
enum class Bound { worst_case, worst_case_rigorous, sigma, sigma_quantization, sigma_in_motion };

/// The bounds of the position, and those behind a filter, in the order of reports.
std::span<const Bound> bounds_of(bool behind_filter);

/// `worst_case`, as requirements and reports name it.
std::string_view name_of(Bound);
/// What it is, in a sentence of a list.
std::string_view summary_of(Bound);

/// Whether it is a variance's root; else it is a worst case.
constexpr bool is_sigma(Bound b) { return b >= Bound::sigma; }

/// A number at each configuration: a bound of a signal, behind a filter or not.
struct Figure {
  std::size_t signal = 0;      ///< index into all_signals of the model
  std::ptrdiff_t filter = -1;  ///< index into the filters; -1: the unfiltered position
  Bound bound = Bound::worst_case;

  friend auto operator<=>(const Figure&, const Figure&) = default;
};

}  // namespace qerr
