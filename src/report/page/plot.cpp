#include <algorithm>
#include <array>
#include <cmath>
#include <unsupported/Eigen/FFT>

#include "core/text.hpp"
#include "report/page/page.hpp"

namespace qerr {

std::vector<std::complex<double>> half_spectrum(const std::vector<double>& values) {
  Eigen::FFT<double> transform;
  transform.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  std::vector<std::complex<double>> spectrum;
  transform.fwd(spectrum, values);
  return spectrum;
}

}  // namespace qerr

namespace qerr::page {

Envelope::Envelope(double from, double to, std::size_t intervals)
    : from_(from),
      per_unit_(to > from ? static_cast<double>(intervals) / (to - from) : 0),
      cells_(intervals, Cell{INFINITY, 0, -INFINITY, 0}) {}

std::vector<std::pair<double, double>> Envelope::points() const {
  std::vector<std::pair<double, double>> all;
  for (const Cell& c : cells_) {
    if (!(c.least <= c.largest)) continue;
    const std::pair low{c.at_least, c.least}, high{c.at_largest, c.largest};
    all.push_back(c.at_least <= c.at_largest ? low : high);
    if (low != high) all.push_back(c.at_least <= c.at_largest ? high : low);
  }
  return all;
}

namespace {

constexpr double top = top_margin, bottom = picture_height - bottom_margin;
constexpr std::size_t styles = 5;  ///< of colours, of dashes and of shapes in the page's CSS

/// Colours repeat after five series, then with other dashes and shapes.
std::string colour_of(std::size_t i) { return 's' + std::to_string(i % styles); }
std::size_t shape_of(std::size_t i) { return (i + i / styles) % styles; }

bool shown(const Plot& p, double x, double y) {
  return std::isfinite(x) && std::isfinite(y) && (!p.x.logarithmic || x > 0) && (!p.y.logarithmic || y > 0);
}

struct AxisExtent {
  double low = INFINITY, high = -INFINITY;

  void include(double value) { low = std::min(low, value), high = std::max(high, value); }
  void include_empty() {
    if (!(low <= high)) low = 1, high = 10;
  }
  /// Whether the data keep a fifth of a linear axis beside the limit.
  bool has_room_for(double limit) const {
    const double spread = high > low ? high - low : std::max(std::abs(high), std::abs(low));
    return std::max(high, limit) - std::min(low, limit) <= 5 * spread;
  }
};

void include_limits(const std::vector<Marker>& limits, const AxisRange& range, AxisExtent& e) {
  const AxisExtent data = e;
  for (const Marker& m : limits) {
    const bool drawable = std::isfinite(m.value) && (!range.logarithmic || m.value > 0);
    const bool alone = !(data.low <= data.high);
    if (drawable && (alone || range.logarithmic || data.has_room_for(m.value))) e.include(m.value);
  }
}

bool within(const Axis& a, double value) {
  return std::isfinite(value) && (!a.logarithmic || value > 0) && a.part(value) > -1e-9 &&
         a.part(value) < 1 + 1e-9;
}

bool has_interval(const Plot& p, const Series& s, std::size_t k) {
  return k < s.intervals.size() && shown(p, s.points[k].first, s.intervals[k].first) &&
         shown(p, s.points[k].first, s.intervals[k].second);
}

PictureFrame with_equal_scales(const Plot& p, const AxisExtent& x, const AxisExtent& y) {
  constexpr double room = 1.1, wide = picture_width - least_left - right_margin, tall = bottom - top;
  const double metres_a_pixel = room * std::max({(x.high - x.low) / wide, (y.high - y.low) / tall, 1e-9});
  const double half_y = 0.5 * metres_a_pixel * tall, middle_y = 0.5 * (y.low + y.high);
  Axis ordinate = unrounded(p.y, middle_y - half_y, middle_y + half_y);
  PictureFrame f = framed({}, std::move(ordinate));
  const double half_x = 0.5 * metres_a_pixel * (f.right - f.left), middle_x = 0.5 * (x.low + x.high);
  f.x = unrounded(p.x, middle_x - half_x, middle_x + half_x);
  return f;
}

PictureFrame frame_of(const Plot& p) {
  AxisExtent x, y;
  for (const Series& s : p.series)
    for (std::size_t k = 0; k < s.points.size(); ++k) {
      if (has_interval(p, s, k)) {
        y.include(s.intervals[k].first), y.include(s.intervals[k].second);
        x.include(s.points[k].first);
      }
      if (shown(p, s.points[k].first, s.points[k].second))
        x.include(s.points[k].first), y.include(s.points[k].second);
    }
  for (const Series& s : p.series)
    for (const auto& [at_x, at_y] : s.marked)
      if (shown(p, at_x, at_y)) x.include(at_x), y.include(at_y);
  include_limits(p.markers, p.x, x);
  include_limits(p.levels, p.y, y);
  x.include_empty();
  y.include_empty();
  if (p.equal_scales) return with_equal_scales(p, x, y);
  return framed(axis(p.x, x.low, x.high, 5), axis(p.y, y.low, y.high, 5));
}

/// A mark of 8 pixels: circle, square, triangle, diamond or cross.
std::string drawn_mark(std::size_t series, double x, double y, const std::string& attributes,
                       const std::string& title) {
  static constexpr std::array<const char*, styles> outlines{
      "", "m-3.6-3.6h7.2v7.2h-7.2z", "m0-4.8l4.6 8.2h-9.2z", "m0-5.2l5.2 5.2l-5.2 5.2l-5.2-5.2z",
      "m-4-4l8 8m0-8l-8 8"};
  const std::size_t shape = shape_of(series);
  const std::string inside = title.empty() ? "" : "<title>" + escaped_markup(title) + "</title>";
  const std::string style = " class=\"mark m" + std::to_string(shape) + ' ' + colour_of(series) + '"';
  if (shape == 0)
    return "<circle" + style + " r=\"4\" cx=\"" + drawn(x) + "\" cy=\"" + drawn(y) + '"' + attributes + '>' +
           inside + "</circle>";
  return "<path" + style + " d=\"M" + drawn(x) + ' ' + drawn(y) + outlines[shape] + '"' + attributes + '>' +
         inside + "</path>";
}

std::string drawn_marks(const Plot& p, const PictureFrame& f, std::size_t i) {
  const Series& s = p.series[i];
  std::string out;
  const auto draw = [&](double x, double y, const std::string& title) {
    if (shown(p, x, y))
      out += drawn_mark(i, f.at_x(x), f.at_y(y), data_attribute("data-x", x) + data_attribute("data-y", y),
                        title);
  };
  if (s.marks)
    for (const auto& [x, y] : s.points)
      draw(x, y, s.name + ": " + readable(x, p.x.unit) + ", " + readable(y, p.y.unit));
  for (const auto& [x, y] : s.marked) draw(x, y, "");
  return out;
}

std::string drawn_intervals(const Plot& p, const PictureFrame& f, std::size_t i) {
  const Series& s = p.series[i];
  std::string out;
  for (std::size_t k = 0; k < s.points.size(); ++k) {
    if (!has_interval(p, s, k)) continue;
    const auto& [from, to] = s.intervals[k];
    const std::string x = drawn(f.at_x(s.points[k].first) - 3);
    out += "<path class=\"error " + colour_of(i) + '"' + data_attribute("data-from", from) +
           data_attribute("data-to", to) + " d=\"M" + x + ' ' + drawn(f.at_y(from)) + "h6m-3 0V" +
           drawn(f.at_y(to)) + "m-3 0h6\"/>";
  }
  return out;
}

/// Out along the upper edge, back along the lower one.
std::string drawn_band(const Plot& p, const PictureFrame& f, std::size_t i) {
  const Series& s = p.series[i];
  std::string upper, lower, data;
  for (std::size_t k = 0; k < s.points.size(); ++k) {
    if (!has_interval(p, s, k)) continue;
    const double x = s.points[k].first;
    const auto& [from, to] = s.intervals[k];
    upper += (upper.empty() ? 'M' : 'L') + drawn(f.at_x(x)) + ' ' + drawn(f.at_y(to));
    lower = 'L' + drawn(f.at_x(x)) + ' ' + drawn(f.at_y(from)) + lower;
    data +=
        (data.empty() ? "" : " ") + significant(x, 6) + ',' + significant(from, 6) + ',' + significant(to, 6);
  }
  if (upper.empty()) return "";
  return "<path class=\"band " + colour_of(i) + "\" data-band=\"" + data + "\" d=\"" + upper + lower +
         "Z\"/>";
}

std::string line_style(const Series& s, std::size_t i) {
  return (s.dots ? "dots " : "line ") + colour_of(i) + (s.dots ? "" : " d" + std::to_string(shape_of(i)));
}

std::string drawn_path(const Plot& p, const PictureFrame& f, std::size_t i) {
  std::string path, data;
  bool pen = false;
  for (const auto& [x, y] : p.series[i].points) {
    if (!shown(p, x, y)) {
      pen = false;
      continue;
    }
    const bool dot = p.series[i].dots;  // a closed path without length, which round ends make a dot
    path += (pen && !dot ? 'L' : 'M') + fixed_point(f.at_x(x), 1) + ' ' + fixed_point(f.at_y(y), 1) +
            (dot ? "Z" : "");
    data += (data.empty() ? "" : " ") + significant(x, 6) + ',' + significant(y, 6);
    pen = true;
  }
  if (path.empty()) return "";
  return "<path class=\"" + line_style(p.series[i], i) + "\" d=\"" + path + "\" data-points=\"" + data +
         "\"/>";
}

std::string drawn_series(const Plot& p, const PictureFrame& f, std::size_t i) {
  const Series& s = p.series[i];
  return "<g data-series=\"" + escaped_markup(s.name) + "\">" + (s.band ? drawn_band(p, f, i) : "") +
         (s.line ? drawn_path(p, f, i) : "") + (s.band ? "" : drawn_intervals(p, f, i)) +
         drawn_marks(p, f, i) + "</g>";
}

std::string limit_style(std::size_t i) { return "limit l" + std::to_string(i % 3); }

std::string key(const std::string& body) {
  return "<li><svg class=\"key\" viewBox=\"0 0 28 12\" aria-hidden=\"true\">" + body + "</svg> ";
}

std::string limit_keys(const std::vector<Marker>& limits, std::size_t first, const Axis& a,
                       const std::string& unit) {
  std::string out;
  for (const Marker& m : limits)
    out += key("<path class=\"" + limit_style(first++) + "\" d=\"M0 6L28 6\"/>") + name_markup(m.name) +
           ": " + escaped_markup(readable(m.value, unit)) +
           (within(a, m.value) ? "" : " (outside the picture)") + "</li>";
  return out;
}

std::string legend(const Plot& p, const PictureFrame& f) {
  std::string out = "<ul class=\"legend\">";
  for (std::size_t i = 0; i < p.series.size(); ++i) {
    const Series& s = p.series[i];
    std::string body;
    if (s.band) body += "<path class=\"band " + colour_of(i) + "\" d=\"M0 1H28V11H0Z\"/>";
    if (s.line)
      body += "<path class=\"" + line_style(s, i) + "\" d=\"" + (s.dots ? "M7 8ZM14 4ZM21 7Z" : "M0 6L28 6") +
              "\"/>";
    if (s.marks || !s.marked.empty()) body += drawn_mark(i, 14, 6, "", "");
    out += key(body) + name_markup(s.name) + "</li>";
  }
  return out + limit_keys(p.markers, 0, f.x, p.x.unit) +
         limit_keys(p.levels, p.markers.size(), f.y, p.y.unit) + "</ul>";
}

std::string drawn_limits(const Plot& p, const PictureFrame& f) {
  std::string out;
  std::size_t i = 0;
  for (const Marker& m : p.markers) {
    const std::string style = limit_style(i++), data = data_attribute("data-limit", m.value);
    if (within(f.x, m.value)) out += drawn_line(f.at_x(m.value), top, f.at_x(m.value), bottom, style, data);
  }
  for (const Marker& m : p.levels) {
    const std::string style = limit_style(i++), data = data_attribute("data-limit", m.value);
    if (within(f.y, m.value))
      out += drawn_line(f.left, f.at_y(m.value), f.right, f.at_y(m.value), style, data);
  }
  return out;
}

}  // namespace

std::string figure(const Plot& p) {
  const PictureFrame f = frame_of(p);
  std::string out = figure_begin(p.title, p.description, p.x, p.y) + drawn_axes(f);
  for (std::size_t i = 0; i < p.series.size(); ++i) out += drawn_series(p, f, i);
  return out + drawn_limits(p, f) + "</svg>" + legend(p, f) + "</figure>\n";
}

namespace {

constexpr double chart_width = 400, row = 28, bar_top = 14, bar_height = 10, margin = 6, axis_height = 26;
constexpr double font = 11, gap = 12;

/// The axis below a chart of so many rows, with its grid and the frame for the script.
struct BarAxis {
  Axis axis;
  double bottom = 0;

  double at(double value) const { return margin + axis.part(value) * (chart_width - 2 * margin); }
};

/// Values of a share are parts of 1, and shown as percentages.
BarAxis bar_axis(double largest, const AxisRange& range, std::size_t rows) {
  const bool parts = range.unit == "%";
  Axis a = axis(parts ? AxisRange{} : range, 0, largest > 0 ? largest : 1, 5);
  const std::string unit =
      a.title.size() > 3 ? ' ' + a.title.substr(2, a.title.size() - 3) : "";  // of ` [um]`
  for (Tick& t : a.ticks) t.label = parts ? significant(100 * t.value, 6) + " %" : t.label + unit;
  return {std::move(a), row * static_cast<double>(rows)};
}

std::string chart_begin(const std::string& title, const std::string& description, const BarAxis& a) {
  std::string grid, labels;
  double free_from = -INFINITY;
  for (const Tick& t : a.axis.ticks) {
    const double at = a.at(t.value), half = 0.5 * 10 * text_width(t.label);
    grid += 'M' + drawn(at) + " 0V" + drawn(a.bottom);
    const double middle = std::clamp(at, half, chart_width - half);
    if (middle - half < free_from) continue;
    labels += drawn_text(middle, a.bottom + 13, "tick mid", t.label);
    free_from = middle + half + 6;
  }
  return figure_begin(title, description, chart_width, a.bottom + axis_height - 8) +
         "<path class=\"grid\" d=\"" + grid + "\"/>" + labels;
}

std::string drawn_bar(const Bar& bar, double y, const BarAxis& a) {
  const double free = chart_width - 2 * margin - gap - font * text_width(bar.text);
  std::string out =
      "<g class=\"row\" data-name=\"" + escaped_markup(bar.name) + '"' +
      data_attribute("data-value", bar.value) + "><title>" + escaped_markup(bar.name + ": " + bar.text) +
      "</title>" + drawn_text(margin, y + 11, "name", fitted(bar.name, free, font)) +
      drawn_text(chart_width - margin, y + 11, "end", bar.text) + "<rect class=\"bar s" +
      std::to_string(bar.colour) + "\" x=\"" + drawn(a.at(0)) + "\" y=\"" + drawn(y + bar_top) +
      "\" width=\"" + drawn(a.at(bar.value) - a.at(0)) + "\" height=\"" + drawn(bar_height) + "\"/>";
  if (bar.error) {
    const double from = a.at(bar.error->first), to = a.at(bar.error->second);
    const double middle = y + bar_top + 0.5 * bar_height;
    out += "<path class=\"error\"" + data_attribute("data-from", bar.error->first) +
           data_attribute("data-to", bar.error->second) + " d=\"M" + drawn(from) + ' ' + drawn(middle) + 'H' +
           drawn(to) + 'M' + drawn(from) + ' ' + drawn(middle - 3) + "v6M" + drawn(to) + ' ' +
           drawn(middle - 3) + "v6\"/>";
  }
  return out + "</g>";
}

}  // namespace

std::string figure(const Bars& b) {
  double largest = b.limit.value_or(0);
  for (const Bar& bar : b.bars) largest = std::max({largest, bar.value, bar.error ? bar.error->second : 0.0});
  const BarAxis a = bar_axis(largest, b.axis, b.bars.size());
  std::string out = chart_begin(b.title, b.description, a);
  double y = 0;
  for (const Bar& bar : b.bars) out += drawn_bar(bar, y, a), y += row;
  // Across the bars, not across their names.
  for (double row_top = 0; b.limit && row_top < y; row_top += row)
    out += drawn_line(a.at(*b.limit), row_top + bar_top - 1, a.at(*b.limit),
                      row_top + bar_top + bar_height + 1, "limit");
  return out + "</svg></figure>\n";
}

}  // namespace qerr::page
