#include "report/page/frame.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/text.hpp"
#include "report/page/markup.hpp"

namespace qerr::page {

namespace {

constexpr double tick_font = 10, title_font = 11, tick_gap = 4;

std::string drawn_title(double x, double y, std::string_view style, const std::string& title, double room) {
  const std::string shown = fitted(title, room, title_font);
  if (shown == title) return drawn_text(x, y, style, title);
  return "<g><title>" + escaped_markup(title) + "</title>" + drawn_text(x, y, style, shown) + "</g>";
}

}  // namespace

PictureFrame framed(Axis x, Axis y, double right) {
  double widest = 0;
  for (const Tick& t : y.ticks) widest = std::max(widest, tick_font * text_width(t.label));
  return {std::move(x), std::move(y), std::max(least_left, widest + 2 * tick_gap), right};
}

Axis unrounded(const AxisRange& range, double least, double largest) {
  Axis a = axis(range, least, largest, 5);
  a.from = least, a.to = largest;
  std::erase_if(a.ticks, [&](const Tick& t) { return t.value < least || t.value > largest; });
  return a;
}

std::string drawn_axes(const PictureFrame& f) {
  constexpr double bottom = picture_height - bottom_margin, gap = 6;
  std::string out, grid;
  double free_from = -INFINITY;
  for (const Tick& t : f.x.ticks) {
    const double at = f.at_x(t.value), half = 0.5 * tick_font * text_width(t.label);
    grid += 'M' + drawn(at) + ' ' + drawn(top_margin) + 'V' + drawn(bottom);
    if (at - half < free_from || at + half > picture_width) continue;
    out += drawn_text(at, bottom + 13, "tick mid", t.label);
    free_from = at + half + gap;
  }
  for (const Tick& t : f.y.ticks) {
    const double at = f.at_y(t.value);
    grid += 'M' + drawn(f.left) + ' ' + drawn(at) + 'H' + drawn(f.right);
    out += drawn_text(f.left - tick_gap, at + 3.5, "tick end", t.label);
  }
  const double middle = 0.5 * (f.left + f.right);
  const double room = 2 * std::min(middle, picture_width - middle) - 2 * tick_gap;
  out = "<path class=\"grid\" d=\"" + grid + "\"/>" + out;
  return out + drawn_title(middle, picture_height - 8, "label mid", f.x.title, room) +
         drawn_title(tick_gap, 11, "label", f.y.title, f.title_room);
}

std::string drawn_text(double x, double y, std::string_view style, const std::string& text) {
  return "<text x=\"" + drawn(x) + "\" y=\"" + drawn(y) + "\" class=\"" + std::string(style) + "\">" +
         escaped_markup(text) + "</text>";
}

std::string drawn_line(double x1, double y1, double x2, double y2, const std::string& style,
                       const std::string& attributes) {
  return "<path class=\"" + style + '"' + attributes + " d=\"M" + drawn(x1) + ' ' + drawn(y1) + 'L' +
         drawn(x2) + ' ' + drawn(y2) + "\"/>";
}

std::string figure_begin(const std::string& title, const std::string& description, const AxisRange& x,
                         const AxisRange& y) {
  return "<figure><figcaption>" + escaped_markup(title) + "</figcaption><svg role=\"img\" viewBox=\"0 0 " +
         fixed_point(picture_width, 0) + ' ' + fixed_point(picture_height, 0) + "\" data-units=\"" +
         escaped_markup(x.unit + '|' + y.unit) + "\" xmlns=\"http://www.w3.org/2000/svg\"><title>" +
         escaped_markup(title) + "</title><desc>" + escaped_markup(description) + "</desc>";
}

}  // namespace qerr::page
