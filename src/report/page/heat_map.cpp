#include "report/page/heat_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/text.hpp"
#include "qerr/core/quantity.hpp"
#include "report/page/frame.hpp"
#include "report/page/markup.hpp"
#include "report/page/png.hpp"

namespace qerr::page {

namespace {

constexpr double bar_left = 328, bar_right = 342, top_edge = top_margin,
                 bottom_edge = picture_height - bottom_margin;

/// Every eighth of cividis; between them linear.
constexpr std::array<Colour, 9> cividis{{{0, 34, 78},
                                         {26, 56, 111},
                                         {64, 77, 107},
                                         {95, 98, 109},
                                         {125, 124, 120},
                                         {155, 145, 119},
                                         {188, 173, 108},
                                         {221, 202, 89},
                                         {254, 232, 56}}};

std::vector<Colour> palette() {
  std::vector<Colour> colours{{0, 0, 0}};
  for (int i = 0; i < heat_steps; ++i) {
    const double at = static_cast<double>(i) / (heat_steps - 1) * (cividis.size() - 1);
    const std::size_t k = std::min(static_cast<std::size_t>(at), cividis.size() - 2);
    Colour& c = colours.emplace_back();
    for (std::size_t part = 0; part < 3; ++part)
      c[part] = static_cast<std::uint8_t>(
          std::lround(std::lerp(cividis[k][part], cividis[k + 1][part], at - static_cast<double>(k))));
  }
  return colours;
}

std::uint8_t index_of(double value, double from, double to) {
  if (!std::isfinite(value)) return 0;
  return static_cast<std::uint8_t>(1 + std::lround((value - from) / (to - from) * (heat_steps - 1)));
}

std::string image(const std::string& style, double left, double top, double right, double bottom,
                  const std::string& attributes, const std::string& file) {
  return "<image class=\"" + style + "\" preserveAspectRatio=\"none\" x=\"" + drawn(left) + "\" y=\"" +
         drawn(top) + "\" width=\"" + drawn(right - left) + "\" height=\"" + drawn(bottom - top) + '"' +
         attributes + " href=\"data:image/png;base64," + base64(file) + "\"/>";
}

/// The area of the map: it ends before the colour bar. With equal scales the longer span fills its axis.
PictureFrame frame_of(const HeatMap& m) {
  constexpr double end = bar_left - 16;
  auto [x0, x1] = m.x_span;
  auto [y0, y1] = m.y_span;
  if (!m.equal_scales) return framed(unrounded(m.x, x0, x1), unrounded(m.y, y0, y1), end);
  const double tall = bottom_edge - top_edge;
  PictureFrame f = framed({}, unrounded(m.y, y0, y1), end);
  const double scale = std::max((x1 - x0) / (f.right - f.left), (y1 - y0) / tall);
  const double more_x = 0.5 * (scale * (f.right - f.left) - (x1 - x0)),
               more_y = 0.5 * (scale * tall - (y1 - y0));
  f = framed({}, unrounded(m.y, y0 - more_y, y1 + more_y), end);
  f.x = unrounded(m.x, x0 - more_x, x1 + more_x);
  return f;
}

PictureFrame beside_bar(PictureFrame f) {
  f.title_room = 0.4 * picture_width;
  return f;
}

/// The scale of the values, with its title above.
std::string colour_bar(const Axis& a) {
  std::vector<std::uint8_t> column;
  for (int i = heat_steps; i > 0; --i) column.push_back(static_cast<std::uint8_t>(i));
  std::string out = image("cells scale", bar_left, top_edge, bar_right, bottom_edge, "",
                          png(1, column.size(), column, palette())) +
                    "<path class=\"edge\" d=\"M" + drawn(bar_left) + ' ' + drawn(top_edge) + 'H' +
                    drawn(bar_right) + 'V' + drawn(bottom_edge) + 'H' + drawn(bar_left) + "Z\"/>";
  for (const Tick& t : a.ticks)
    out += drawn_text(bar_right + 4, bottom_edge - a.part(t.value) * (bottom_edge - top_edge) + 3.5, "tick",
                      t.label);
  return out + drawn_text(picture_width - 4, 11, "label end", fitted(a.title, 0.55 * picture_width, 11));
}

std::string span_attribute(const HeatMap& m) {
  return " data-span=\"" + shortest(m.x_span.first) + ' ' + shortest(m.x_span.second) + ' ' +
         shortest(m.y_span.first) + ' ' + shortest(m.y_span.second) + '"';
}

}  // namespace

std::string figure(const HeatMap& m) {
  double low = INFINITY, high = -INFINITY;
  for (const double v : m.cells)
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  if (!(low <= high)) low = 0, high = 1;
  const Axis scale = axis(m.value, low, high, 6);
  std::vector<std::uint8_t> pixels;
  for (std::size_t r = m.rows; r-- > 0;)
    for (std::size_t c = 0; c < m.columns; ++c)
      pixels.push_back(index_of(m.cells[r * m.columns + c], scale.from, scale.to));
  const PictureFrame f = beside_bar(frame_of(m));
  const auto [x0, x1] = m.x_span;
  const auto [y0, y1] = m.y_span;
  return figure_begin(m.title, m.description, m.x, m.y) + drawn_axes(f) +
         image("cells", f.at_x(x0), f.at_y(y1), f.at_x(x1), f.at_y(y0),
               data_attribute("data-from", scale.from) + data_attribute("data-to", scale.to) +
                   span_attribute(m) + " data-unit=\"" + escaped_markup(m.value.unit) + '"',
               png(m.columns, m.rows, pixels, palette())) +
         colour_bar(scale) + "</svg></figure>\n";
}

}  // namespace qerr::page
