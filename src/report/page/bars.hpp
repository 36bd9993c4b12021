#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "report/page/frame.hpp"

namespace qerr::page {

/// Horizontal bars from zero, as SVG.

struct Bar {
  std::string name;
  double value = 0;                                     ///< [SI], not negative
  std::string text;                                     ///< the value for people
  std::optional<std::pair<double, double>> error = {};  ///< from, to [SI]
  int colour = 0;                                       ///< of those of lines, 0 to 4
};

struct Bars {
  std::string title, description;
  std::vector<Bar> bars;
  AxisRange axis = {"", "%"};        ///< with the unit %, values are parts of 1
  std::optional<double> limit = {};  ///< a line across all bars [SI]
};

/// One bar below the other, in the order given, over one axis; each with its name above it. A bar carries its
/// value as `data-value`, the name as `data-name`.
std::string figure(const Bars&);

}  // namespace qerr::page
