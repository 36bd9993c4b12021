#include "report/page/bars.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "report/page/markup.hpp"

namespace qerr::page {

namespace {

constexpr double chart_width = 400, row = 30, bar_top = 15, bar_height = 9, margin = 2;
constexpr double font = 11, gap = 12;

double largest_of(const Bars& b) {
  double largest = 0;
  for (const Bar& bar : b.bars) largest = std::max({largest, bar.value, bar.error ? bar.error->second : 0.0});
  return largest > 0 ? largest : 1;
}

std::string drawn_bar(const Bar& bar, double y, double scale) {
  const std::string full = bar.name + ": " + bar.text;
  const double free = chart_width - 2 * margin - gap - font * text_width(bar.text);
  std::string out = "<g class=\"row\" data-name=\"" + escaped_markup(bar.name) + '"' +
                    data_attribute("data-value", bar.value) + "><title>" + escaped_markup(full) +
                    "</title><text class=\"name\" x=\"2\" y=\"" + drawn(y + 11) + "\">" +
                    escaped_markup(fitted(bar.name, free, font)) + "</text><text class=\"end\" x=\"" +
                    drawn(chart_width - margin) + "\" y=\"" + drawn(y + 11) + "\">" +
                    escaped_markup(bar.text) + "</text><rect class=\"bar\" x=\"" + drawn(margin) + "\" y=\"" +
                    drawn(y + bar_top) + "\" width=\"" + drawn(bar.value * scale) + "\" height=\"" +
                    drawn(bar_height) + "\"/>";
  if (bar.error) {
    const double from = margin + bar.error->first * scale, to = margin + bar.error->second * scale;
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
  const double scale = (chart_width - 2 * margin) / largest_of(b);
  std::string out = "<figure><figcaption>" + escaped_markup(b.title) +
                    "</figcaption><svg role=\"img\" viewBox=\"0 0 " + fixed_point(chart_width, 0) + ' ' +
                    fixed_point(row * static_cast<double>(b.bars.size()), 0) +
                    "\" xmlns=\"http://www.w3.org/2000/svg\"><title>" + escaped_markup(b.title) +
                    "</title><desc>" + escaped_markup(b.description) + "</desc>";
  double y = 0;
  for (const Bar& bar : b.bars) {
    out += drawn_bar(bar, y, scale);
    y += row;
  }
  return out + "</svg></figure>\n";
}

}  // namespace qerr::page
