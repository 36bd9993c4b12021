#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/text.hpp"
#include "qerr/core/quantity.hpp"
#include "report/page/page.hpp"
#include "report/text_table.hpp"

namespace qerr::page {

namespace {

constexpr std::string_view replacement = "\xEF\xBF\xBD";

/// Marks that qerr sets itself (page.hpp): U+2068 and U+2069 isolate a name, U+200E begins a text.
bool set_by_qerr(std::string_view symbol) {
  return symbol == "\xE2\x81\xA8" || symbol == "\xE2\x81\xA9" || symbol == "\xE2\x80\x8E";
}

std::string_view escaped_symbol(std::string_view symbol) {
  if (symbol == "\xEF\xBF\xBE" || symbol == "\xEF\xBF\xBF") return replacement;  // no characters of XML
  if (symbol == "\n" || symbol == "\t" || set_by_qerr(symbol)) return symbol;
  if (hidden_length(symbol, 0) > 0) return replacement;
  switch (symbol[0]) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    default:
      return symbol;
  }
}

std::string titled(const AxisRange& range, const std::string& unit) {
  return unit.empty() ? range.label : range.label + " [" + unit + ']';
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
  const double step = round_step((largest - least) / most, 1e-9);
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
  for (const char digit : fixed_point(std::abs(exponent), 0)) out += raised[digit - '0'];
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

std::string escaped_markup(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    out += length == 0 ? replacement : escaped_symbol(text.substr(at, length));
    at += length == 0 ? 1 : length;
  }
  return out;
}

std::string name_markup(std::string_view name) {
  return name.empty() ? "" : "<bdi>" + escaped_markup(name) + "</bdi>";
}

std::string shortened(std::string_view name, std::size_t most) {
  std::vector<std::string_view> symbols;
  for (std::size_t at = 0; at < name.size(); at += symbols.back().size())
    symbols.push_back(name.substr(at, std::max<std::size_t>(1, utf8_length(name, at))));
  if (symbols.size() <= most) return std::string(name);
  const std::size_t front = most / 2, back = most - 1 - front;
  std::string out;
  for (std::size_t i = 0; i < front; ++i) out += symbols[i];
  out += "\u2026";
  for (std::size_t i = symbols.size() - back; i < symbols.size(); ++i) out += symbols[i];
  return out;
}

double text_width(std::string_view text) {
  constexpr double narrow = 0.65, capital = 0.8, square = 1.05;  // DejaVu Sans, the widest usual font
  constexpr unsigned first_square = 0x1100;                      // Hangul; the scripts of East Asia follow
  double width = 0;
  for (std::size_t at = 0; at < text.size(); at += std::max<std::size_t>(1, utf8_length(text, at))) {
    const unsigned symbol = code_point(text, at);
    const bool punctuation = symbol >= 0x2000 && symbol < 0x2100;
    const bool wide = std::string_view("MWmw@%").find(text[at]) != std::string_view::npos;
    width += wide || symbol == 0x2026 || (symbol >= first_square && !punctuation) ? square
             : symbol >= 'A' && symbol <= 'Z'                                     ? capital
                                                                                  : narrow;
  }
  return width;
}

std::string fitted(std::string_view text, double width, double font_size) {
  std::string out(text);
  for (std::size_t most = display_width(text); most > 1 && text_width(out) * font_size > width; --most)
    out = shortened(text, most - 1);
  return out;
}

std::string drawn(double value) { return fixed_point(value, 2); }

std::string data_attribute(std::string_view name, double value) {
  return ' ' + std::string(name) + "=\"" + shortest(value) + '"';
}

double Axis::part(double value) const {
  return logarithmic ? std::log(value / from) / std::log(to / from) : (value - from) / (to - from);
}

Axis axis(const AxisRange& range, double least, double largest, int most) {
  return range.logarithmic ? logarithmic(range, least, largest, most) : linear(range, least, largest, most);
}

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
