#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "report/sweep/abscissa.hpp"

namespace qerr {

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

/// @param figures     that are drawn of each variant
/// @param most_bytes  of the pictures, about
DrawnVariants drawn_variants(const SweepGrid&, std::size_t figures, std::size_t most_bytes);

}  // namespace qerr
