#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "report/page/axis.hpp"

/// A figure over a grid of two quantities, as a palette picture inside SVG.
namespace qerr::page {

struct HeatMap {
  std::string title, description;
  AxisRange x, y, value;
  std::pair<double, double> x_span, y_span;  ///< of the grid [SI]
  std::size_t columns = 1, rows = 1;
  std::vector<double> cells;  ///< row by row from the least y [SI]; not finite: an empty cell
  bool equal_scales = false;  ///< a metre is as long on both axes
};

/// Steps of the scale: 0.4 % of its range is below what an eye tells apart.
inline constexpr int heat_steps = 255;

/// The picture with a colour bar. Colours are those of cividis (Nunez, Anderton, Renslow, PLOS ONE 2018):
/// they rise in lightness with any colour vision, and in black and white.
///
/// The value of a cell is rounded to a step of the scale: `data-from` and `data-to` of the picture are the
/// values of the palette's indices 1 and 255, index 0 is an empty cell; `data-span` has the edges of the
/// grid.
std::string figure(const HeatMap&);

}  // namespace qerr::page
