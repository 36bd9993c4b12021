#include "report/page/plot.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "report/page/markup.hpp"

namespace qerr::page {

namespace {

constexpr double width = 400, height = 250, left = 52, right = 14, top = 22, bottom = 40;
constexpr std::size_t styles = 5;  ///< of lines in the page's CSS

struct Frame {
  Axis x, y;

  double at_x(double value) const { return left + x.part(value) * (width - left - right); }
  double at_y(double value) const { return height - bottom - y.part(value) * (height - top - bottom); }
};

bool shown(const Plot& p, double x, double y) {
  return std::isfinite(x) && std::isfinite(y) && (!p.x.logarithmic || x > 0) && (!p.y.logarithmic || y > 0);
}

/// The axis from `least` to `largest` themselves.
Axis unrounded(const AxisRange& range, double least, double largest) {
  Axis a = axis(range, least, largest, 5);
  a.from = least, a.to = largest;
  std::erase_if(a.ticks, [&](const Tick& t) { return t.value < least || t.value > largest; });
  return a;
}

Frame with_equal_scales(const Plot& p, double low_x, double high_x, double low_y, double high_y) {
  constexpr double room = 1.1, wide = width - left - right, tall = height - top - bottom;
  const double metres_a_pixel = room * std::max({(high_x - low_x) / wide, (high_y - low_y) / tall, 1e-9});
  const double half_x = 0.5 * metres_a_pixel * wide, half_y = 0.5 * metres_a_pixel * tall;
  const double middle_x = 0.5 * (low_x + high_x), middle_y = 0.5 * (low_y + high_y);
  return {unrounded(p.x, middle_x - half_x, middle_x + half_x),
          unrounded(p.y, middle_y - half_y, middle_y + half_y)};
}

Frame frame_of(const Plot& p) {
  double low_x = INFINITY, high_x = -INFINITY, low_y = INFINITY, high_y = -INFINITY;
  for (const Series& s : p.series)
    for (const auto& [x, y] : s.points) {
      if (!shown(p, x, y)) continue;
      low_x = std::min(low_x, x), high_x = std::max(high_x, x);
      low_y = std::min(low_y, y), high_y = std::max(high_y, y);
    }
  for (const Marker& m : p.markers)
    if (shown(p, m.value, 1)) low_x = std::min(low_x, m.value), high_x = std::max(high_x, m.value);
  if (!(low_x <= high_x)) low_x = 1, high_x = 10;
  if (!(low_y <= high_y)) low_y = 1, high_y = 10;
  if (p.equal_scales) return with_equal_scales(p, low_x, high_x, low_y, high_y);
  return {axis(p.x, low_x, high_x, 5), axis(p.y, low_y, high_y, 5)};
}

std::string text(double x, double y, const std::string& kind, const std::string& what) {
  return "<text x=\"" + drawn(x) + "\" y=\"" + drawn(y) + "\" class=\"" + kind + "\">" +
         escaped_markup(what) + "</text>";
}

std::string line(double x1, double y1, double x2, double y2, const std::string& kind) {
  return "<path class=\"" + kind + "\" d=\"M" + drawn(x1) + ' ' + drawn(y1) + 'L' + drawn(x2) + ' ' +
         drawn(y2) + "\"/>";
}

/// Grid, ticks and titles; a tick whose label would touch the one before has none.
std::string axes(const Frame& f) {
  constexpr double character = 5.6, gap = 6;  // of the font of ticks, 10 px
  std::string out;
  double free_from = -INFINITY;
  for (const Tick& t : f.x.ticks) {
    const double at = f.at_x(t.value), half = 0.5 * character * static_cast<double>(display_width(t.label));
    out += line(at, top, at, height - bottom, "grid");
    if (at - half < free_from || at + half > width) continue;
    out += text(at, height - bottom + 13, "tick mid", t.label);
    free_from = at + half + gap;
  }
  for (const Tick& t : f.y.ticks) {
    const double at = f.at_y(t.value);
    out += line(left, at, width - right, at, "grid") + text(left - 4, at + 3.5, "tick end", t.label);
  }
  return out + text(0.5 * (left + width - right), height - 8, "label mid", f.x.title) +
         text(4, 11, "label", f.y.title);
}

std::string drawn_series(const Plot& p, const Frame& f, std::size_t i) {
  const Series& s = p.series[i];
  const std::string kind = "s" + std::to_string(i % styles);
  std::string path, data, marks;
  bool pen = false;
  for (const auto& [x, y] : s.points) {
    if (!shown(p, x, y)) {
      pen = false;
      continue;
    }
    path += (pen ? 'L' : 'M') + drawn(f.at_x(x)) + ' ' + drawn(f.at_y(y));
    data += (data.empty() ? "" : " ") + significant(x, 6) + ',' + significant(y, 6);
    pen = true;
    if (s.marks)
      marks += "<circle class=\"" + kind + "\" r=\"4\" cx=\"" + drawn(f.at_x(x)) + "\" cy=\"" +
               drawn(f.at_y(y)) + '"' + data_attribute("data-x", x) + data_attribute("data-y", y) +
               "><title>" +
               escaped_markup(s.name + ": " + readable(x, p.x.unit) + ", " + readable(y, p.y.unit)) +
               "</title></circle>";
  }
  if (s.line && !path.empty())
    path = "<path class=\"line " + kind + "\" d=\"" + path + "\" data-points=\"" + data + "\"/>";
  else
    path.clear();
  return "<g data-series=\"" + escaped_markup(s.name) + "\">" + path + marks + "</g>";
}

std::string legend(const Plot& p) {
  std::string out = "<ul class=\"legend\">";
  for (std::size_t i = 0; i < p.series.size(); ++i) {
    const std::string kind = "s" + std::to_string(i % styles);
    out += "<li><svg class=\"key\" viewBox=\"0 0 28 8\" aria-hidden=\"true\">";
    if (p.series[i].line) out += "<path class=\"line " + kind + "\" d=\"M0 4L28 4\"/>";
    if (p.series[i].marks) out += "<circle class=\"" + kind + "\" r=\"4\" cx=\"14\" cy=\"4\"/>";
    out += "</svg> " + name_markup(p.series[i].name) + "</li>";
  }
  for (const Marker& m : p.markers)
    out +=
        "<li><svg class=\"key\" viewBox=\"0 0 28 8\" aria-hidden=\"true\"><path class=\"limit\" "
        "d=\"M0 4L28 4\"/></svg> " +
        name_markup(m.name) + ": " + escaped_markup(readable(m.value, p.x.unit)) + "</li>";
  return out + "</ul>";
}

}  // namespace

std::string figure(const Plot& p) {
  const Frame f = frame_of(p);
  std::string out = "<figure><figcaption>" + escaped_markup(p.title) +
                    "</figcaption><svg role=\"img\" viewBox=\"0 0 " + fixed_point(width, 0) + ' ' +
                    fixed_point(height, 0) + "\" xmlns=\"http://www.w3.org/2000/svg\"><title>" +
                    escaped_markup(p.title) + "</title><desc>" + escaped_markup(p.description) + "</desc>" +
                    axes(f);
  for (std::size_t i = 0; i < p.series.size(); ++i) out += drawn_series(p, f, i);
  for (const Marker& m : p.markers)
    if (shown(p, m.value, 1)) out += line(f.at_x(m.value), top, f.at_x(m.value), height - bottom, "limit");
  return out + "</svg>" + legend(p) + "</figure>\n";
}

}  // namespace qerr::page
