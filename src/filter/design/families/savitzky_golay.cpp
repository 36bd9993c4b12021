#include "filter/design/families/families.hpp"

namespace qerr {
namespace {

Filter design(const FilterDesign& wanted) {
  const int window = whole_number(wanted, "window", 0, 1, max_window);
  if (window == 0) throw Error("window", "missing key", "", "add e.g. 'window: 21'");
  const int order = whole_number(wanted, "polynomial_order", 2, 0, max_polynomial_order);
  const bool center = checked_choice(wanted, "position", {"center", "end"}) == "center";
  return polynomial_fit(wanted, window, order, center ? 0.5 * (window - 1) : 0);
}

}  // namespace

FilterFamily savitzky_golay_family() {
  return {
      "savitzky_golay",
      "estimates the derivative itself, of a polynomial fitted to the window, late by (window - 1) T/2 at "
      "its center, by nothing at its end (scipy.signal.savgol_coeffs)",
      {window_row(),
       key::integer("polynomial_order", "at least the derivative, below the window")
           .otherwise(2)
           .within(0, max_polynomial_order),
       key::choice("position", "center|end", "where in the window the derivative is evaluated")},
      design};
}

}  // namespace qerr
