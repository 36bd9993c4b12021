#include "report/page/frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/text.hpp"
#include "qerr/core/quantity.hpp"
#include "report/page/markup.hpp"

namespace qerr::page {

namespace {

std::string titled(const AxisRange& range, const std::string& unit) {
  return unit.empty() ? range.label : range.label + " [" + unit + ']';
}

/// The smallest of 1, 2, 5 times a power of ten that is not below the value.
double round_step(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double digit : {1.0, 2.0, 5.0})
    if (digit * power >= least * (1 - 1e-9)) return digit * power;
  return 10 * power;
}

Axis linear(const AxisRange& range, double least, double largest, int most) {
  const double magnitude = std::max(std::abs(least), std::abs(largest));
  // Labels have six digits: a spread below 1e-4 would give ticks that read alike. It is drawn as one value in
  // the middle.
  if (!(largest - least > 1e-4 * magnitude)) {
    const double half = magnitude == 0 ? 1 : 0.5 * magnitude;
    least -= half;
    largest += half;
  }
  const double step = round_step((largest - least) / most);
  const double first = std::floor(least / step + 1e-9), last = std::ceil(largest / step - 1e-9);
  const PrefixedUnit unit = range.unit.empty() || !range.prefix
                                ? PrefixedUnit{1, range.unit}
                                : prefixed(std::max(std::abs(first), std::abs(last)) * step, range.unit);
  Axis a{titled(range, unit.unit), false, first * step, last * step, {}, unit.factor};
  for (double k = first; k <= last + 0.5; ++k)
    a.ticks.push_back({k * step, significant(k * step / unit.factor, 6)});
  return a;
}

/// Powers of ten beyond four digits as such: `10⁻⁷`.
std::string decade_label(double value) {
  constexpr std::array<const char*, 10> raised{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  const double exponent = std::round(std::log10(value));
  if (std::abs(exponent) < 4 || std::abs(value / std::pow(10, exponent) - 1) > 1e-9)
    return significant(value, 6);
  std::string out = exponent < 0 ? "10⁻" : "10";
  for (const char digit : fixed_point(std::abs(exponent), 0))
    out += raised[static_cast<std::size_t>(digit - '0')];
  return out;
}

Axis logarithmic(const AxisRange& range, double least, double largest, int most) {
  const double first = std::floor(std::log10(least) + 1e-9);
  const double last = std::max(std::ceil(std::log10(largest) - 1e-9), first + 1);
  const double every = std::max(1.0, std::ceil((last - first) / most));
  const PrefixedUnit unit = range.unit.empty() || !range.prefix
                                ? PrefixedUnit{1, range.unit}
                                : prefixed(std::pow(10, std::floor((first + last) / 2)), range.unit);
  Axis a{titled(range, unit.unit), true, std::pow(10, first), std::pow(10, last), {}, unit.factor};
  for (double decade = first; decade <= last; decade += every)
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10, decade);
      if ((digit > 1 && last - first > 2) || value > a.to * (1 + 1e-9)) continue;
      a.ticks.push_back({value, decade_label(value / unit.factor)});
    }
  return a;
}

}  // namespace

double Axis::part(double value) const {
  return logarithmic ? std::log(value / from) / std::log(to / from) : (value - from) / (to - from);
}

Axis axis(const AxisRange& range, double least, double largest, int most) {
  return range.logarithmic ? logarithmic(range, least, largest, most) : linear(range, least, largest, most);
}

namespace {

constexpr double tick_font = 10, title_font = 11, tick_gap = 4;

std::string drawn_title(double x, double y, std::string_view style, const std::string& title, double room) {
  const std::string shown = fitted(title, room, title_font);
  if (shown == title) return drawn_text(x, y, style, title);
  return "<g><title>" + escaped_markup(title) + "</title>" + drawn_text(x, y, style, shown) + "</g>";
}

/// Ends, scale and unit of an axis.
std::string axis_attribute(const std::string& name, const Axis& a) {
  return ' ' + name + "=\"" + shortest(a.from) + ' ' + shortest(a.to) + (a.logarithmic ? " 1 " : " 0 ") +
         shortest(a.unit) + '"';
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
  out = "<g class=\"axes\" data-frame=\"" + drawn(f.left) + ' ' + drawn(f.right) + ' ' + drawn(top_margin) +
        ' ' + drawn(bottom) + '"' + axis_attribute("data-abscissa", f.x) +
        axis_attribute("data-ordinate", f.y) + "><path class=\"grid\" d=\"" + grid + "\"/>" + out + "</g>";
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

std::string figure_begin(const std::string& title, const std::string& description, double width,
                         double height, const std::string& attributes) {
  return "<figure><figcaption>" + escaped_markup(title) + "</figcaption><svg role=\"img\" viewBox=\"0 0 " +
         fixed_point(width, 0) + ' ' + fixed_point(height, 0) + '"' + attributes +
         " xmlns=\"http://www.w3.org/2000/svg\"><title>" + escaped_markup(title) + "</title><desc>" +
         escaped_markup(description) + "</desc>";
}

std::string figure_begin(const std::string& title, const std::string& description, const AxisRange& x,
                         const AxisRange& y) {
  return figure_begin(title, description, picture_width, picture_height,
                      " data-units=\"" + escaped_markup(x.unit + '|' + y.unit) + '"');
}

}  // namespace qerr::page
