#include "report/page/bars.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "report/page/markup.hpp"

namespace qerr::page {

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
  return "<figure><figcaption>" + escaped_markup(title) + "</figcaption><svg role=\"img\" viewBox=\"0 0 " +
         fixed_point(chart_width, 0) + ' ' + fixed_point(a.bottom + axis_height - 8, 0) +
         "\" xmlns=\"http://www.w3.org/2000/svg\"><title>" + escaped_markup(title) + "</title><desc>" +
         escaped_markup(description) + "</desc><path class=\"grid\" d=\"" + grid + "\"/>" + labels;
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
