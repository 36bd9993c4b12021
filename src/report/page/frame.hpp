#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace qerr::page {

/// Text and numbers in markup that is both HTML 5 and well-formed XML.

/// The text for element content and for attributes in double quotes: `&`, `<`, `>`, `"` as entities. Control
/// characters, bytes that are no UTF-8 and code points that XML excludes become U+FFFD.
std::string escaped_markup(std::string_view text);

/// A name from outside in running text, isolated from the writing direction around it.
std::string name_markup(std::string_view name);

/// At most `most` code points of a name: the middle of a longer one is an ellipsis.
std::string shortened(std::string_view name, std::size_t most);

/// Width of a text in pictures, estimated from above for the sans-serif fonts of browsers [font sizes]:
/// more for capital letters, most for scripts with square characters.
double text_width(std::string_view text);

/// The text, shortened in its middle to the width [pixels] that is left for it.
std::string fitted(std::string_view text, double width, double font_size);

/// A coordinate in a picture, two decimals.
std::string drawn(double value);

/// ` name="value"` with every digit of the value.
std::string data_attribute(std::string_view name, double value);

/// Axes of pictures.

struct AxisRange {
  std::string label;      ///< the quantity
  std::string unit = {};  ///< SI, without a prefix; "" for a pure number
  bool logarithmic = false;
  bool prefix = true;  ///< an SI prefix by the size of the values
};

struct Tick {
  double value = 0;   ///< [SI]
  std::string label;  ///< in the unit of the axis' title
};

struct Axis {
  std::string title;  ///< quantity and unit with its SI prefix: `gain [krad/s]`
  bool logarithmic = false;
  double from = 0, to = 1;  ///< [SI]
  std::vector<Tick> ticks;
  double unit = 1;  ///< of the title [SI]

  /// Where a value lies: 0 at `from`, 1 at `to`.
  double part(double value) const;
};

/// An axis from a tick at or below `least` to one at or above `largest`, with round ticks: 1, 2 or 5 times a
/// power of ten, or powers of ten on a logarithmic axis (1, 2, 5 of each where it has less than two decades).
/// @param most  ticks, about
/// @pre finite values; on a logarithmic axis above 0
Axis axis(const AxisRange&, double least, double largest, int most = 6);

/// What pictures over two axes have in common.

/// Of a picture and of the margins around the area of its axes; the left one grows with its labels [pixels].
inline constexpr double picture_width = 400, picture_height = 250;
inline constexpr double least_left = 40, right_margin = 14, top_margin = 22, bottom_margin = 40;

struct PictureFrame {
  Axis x, y;
  double left = least_left, right = picture_width - right_margin;
  double title_room = picture_width - 8;  ///< of the ordinate's title

  double at_x(double value) const { return left + x.part(value) * (right - left); }
  double at_y(double value) const {
    return picture_height - bottom_margin - y.part(value) * (picture_height - top_margin - bottom_margin);
  }
};

/// The area of the axes: it leaves room for the labels of the ordinate.
/// @param right  end of the area [pixels]
PictureFrame framed(Axis x, Axis y, double right = picture_width - right_margin);

/// The axis from `least` to `largest` themselves, not to round numbers.
Axis unrounded(const AxisRange&, double least, double largest);

/// Grid, ticks and titles; a tick whose label would touch the one before has none, a title that is too long
/// is shortened. For the script that zooms: `data-frame` has left, right, top and bottom [pixels],
/// `data-abscissa` and `data-ordinate` from and to [SI], 1 for a logarithmic axis, and the unit [SI].
std::string drawn_axes(const PictureFrame&);

std::string drawn_text(double x, double y, std::string_view style, const std::string& text);

/// A straight line, with further attributes.
std::string drawn_line(double x1, double y1, double x2, double y2, const std::string& style,
                       const std::string& attributes = "");

/// Opens `figure` and `svg`. @param attributes  of the latter
std::string figure_begin(const std::string& title, const std::string& description, double width,
                         double height, const std::string& attributes = "");

/// With the units of both axes for the script.
std::string figure_begin(const std::string& title, const std::string& description, const AxisRange& x,
                         const AxisRange& y);

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
