#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/page/frame.hpp"

namespace qerr::page {

/// Palette pictures as PNG (ISO/IEC 15948), small enough to stand in a page.

using Colour = std::array<std::uint8_t, 3>;  ///< red, green, blue

/// The picture as PNG with eight bits a pixel. Colour 0 is transparent.
///
/// Deflate (RFC 1951) with the fixed code and matches of distance 1: runs, such as an empty surrounding, take
/// few bits, and no library is needed.
/// @param pixels   indices into the palette, row by row from the top; width * height
/// @param palette  1 to 256 colours
std::string png(std::size_t width, std::size_t height, const std::vector<std::uint8_t>& pixels,
                const std::vector<Colour>& palette);

/// RFC 4648.
std::string base64(std::string_view bytes);

/// A figure over a grid of two quantities, as a palette picture inside SVG.

struct HeatMap {
  std::string title, description;
  AxisRange x, y, value;
  std::pair<double, double> x_span, y_span;  ///< of the grid [SI]
  std::size_t columns = 1, rows = 1;
  std::vector<double> cells;  ///< row by row from the least y [SI]; not finite: an empty cell
  bool equal_scales = false;  ///< a metre is as long on both axes
};

/// Every eighth of cividis (Nunez, Anderton, Renslow, PLOS ONE 2018); between them it is linear here.
extern const std::array<Colour, 9> cividis;

/// Steps of the scale: 0.4 % of its range is below what an eye tells apart.
inline constexpr int heat_steps = 255;

/// The picture with a colour bar. Colours are those of cividis: they rise in lightness with any colour
/// vision, and in black and white.
///
/// The value of a cell is rounded to a step of the scale: `data-from` and `data-to` of the picture are the
/// values of the palette's indices 1 and 255, index 0 is an empty cell; `data-span` has the edges of the
/// grid.
std::string figure(const HeatMap&);

}  // namespace qerr::page
