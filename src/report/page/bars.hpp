#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

/// Horizontal bars from zero, as SVG.
namespace qerr::page {

struct Bar {
  std::string name;
  double value = 0;                                     ///< [SI], not negative
  std::string text;                                     ///< the value for people
  std::optional<std::pair<double, double>> error = {};  ///< from, to [SI]
};

struct Bars {
  std::string title, description;
  std::vector<Bar> bars;
};

/// One bar below the other, in the order given, to one scale; each with its name above it. A bar carries its
/// value as `data-value`, the name as `data-name`.
std::string figure(const Bars&);

}  // namespace qerr::page
