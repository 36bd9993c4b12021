#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "report/sweep/grid.hpp"

namespace qerr {

/// The key of a sweep whose values are numbers of one dimension: what figures are drawn over.
struct SweepAbscissa {
  std::size_t axis = 0;
  std::string key, unit;
  std::vector<double> values;      ///< of the axis' steps [SI]
  std::vector<std::size_t> order;  ///< steps by ascending value
  bool logarithmic = false;        ///< equally spaced in the logarithm
};

/// One of each axis that has such a key, with two values at least: of its first one.
std::vector<SweepAbscissa> abscissas_of(const SweepGrid&);

/// A value of a key for people: a number of many digits, such as the steps of a logarithmic range have, with
/// six of them.
std::string short_value(const std::string& name);

/// `most` of `count` numbers from 0 on, evenly spread, the first and the last one among them.
std::vector<std::size_t> evenly_chosen(std::size_t count, std::size_t most);

/// Which variants of a sweep a page draws: it depends on the grid alone, so that the same ones are drawn
/// whatever the threads.
struct DrawnVariants {
  /// The variants of one combination of the other keys, by ascending value of the abscissa.
  struct Line {
    std::string name;
    std::vector<std::uint64_t> variants;
  };

  std::optional<SweepAbscissa> abscissa;  ///< empty: one bar a variant, in a single line
  std::vector<Line> lines;
  std::uint64_t lines_in_all = 1;  ///< combinations of the other keys
  std::size_t points_in_all = 0;   ///< of a line

  /// The value of a variant on the abscissa.
  double value(const SweepGrid&, std::uint64_t variant) const;
};

/// Over each axis of numbers in turn, at most four of them; one, of bars, where there is none.
/// @param figures     that are drawn of each variant
/// @param most_bytes  of the pictures, about
std::vector<DrawnVariants> drawn_variants(const SweepGrid&, std::size_t figures, std::size_t most_bytes);

}  // namespace qerr
