#include <algorithm>

#include "filter/design/families/families.hpp"

namespace qerr {
namespace {

Filter design(const FilterDesign& wanted) {
  const int window = whole_number(wanted, "window", 0, 1, max_window);
  if (window == 0) throw Error("window", "missing key", "", "add e.g. 'window: 21'");
  const int order =
      whole_number(wanted, "polynomial_order", std::max(1, wanted.derivative), 0, max_polynomial_order);
  return polynomial_fit(wanted, window, order, 0);
}

}  // namespace

FilterFamily least_squares_family() {
  return {"least_squares",
          "estimates the derivative itself: of the line or polynomial fitted to the window, at its newest "
          "sample; late by (window - 1) T/2 where the order equals the derivative 1, by nothing above it",
          {window_row(), key::integer("polynomial_order",
                                      "of the fit; default: the derivative, and a line for derivative 0")
                             .within(0, max_polynomial_order)},
          design};
}

}  // namespace qerr
