#pragma once

#include <string>
#include <vector>

/// How factors lead from one value to another, as SVG.
namespace qerr::page {

struct WaterfallFactor {
  std::string name;
  double value = 1;  ///< >= 0
};

struct Waterfall {
  std::string title, description;
  std::string first, last;  ///< names of the values
  double start = 0;         ///< [SI], not negative
  std::string unit;
  std::vector<WaterfallFactor> factors;
};

/// A bar of the start, a piece between the products before and after each factor, and a bar of the product of
/// all, one below the other, to one scale. A piece carries its factor as `data-value`, the products as
/// `data-from` and `data-to`; the first and the last bar the value as `data-value`.
std::string figure(const Waterfall&);

}  // namespace qerr::page
