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

std::string drawn_row(const std::string& name, const std::string& text, const std::string& data,
                      const std::string& inside, double y) {
  const double free = chart_width - 2 * margin - gap - font * text_width(text);
  return "<g class=\"row\" data-name=\"" + escaped_markup(name) + '"' + data + "><title>" +
         escaped_markup(name + ": " + text) + "</title><text class=\"name\" x=\"" + drawn(margin) +
         "\" y=\"" + drawn(y + 11) + "\">" + escaped_markup(fitted(name, free, font)) +
         "</text><text class=\"end\" x=\"" + drawn(chart_width - margin) + "\" y=\"" + drawn(y + 11) + "\">" +
         escaped_markup(text) + "</text>" + inside + "</g>";
}

std::string drawn_rectangle(double from, double to, double y, int colour) {
  return "<rect class=\"bar s" + std::to_string(colour) + "\" x=\"" + drawn(from) + "\" y=\"" +
         drawn(y + bar_top) + "\" width=\"" + drawn(to - from) + "\" height=\"" + drawn(bar_height) + "\"/>";
}

std::string drawn_bar(const Bar& bar, double y, const BarAxis& a) {
  std::string inside = drawn_rectangle(a.at(0), a.at(bar.value), y, bar.colour);
  if (bar.error) {
    const double from = a.at(bar.error->first), to = a.at(bar.error->second);
    const double middle = y + bar_top + 0.5 * bar_height;
    inside += "<path class=\"error\"" + data_attribute("data-from", bar.error->first) +
              data_attribute("data-to", bar.error->second) + " d=\"M" + drawn(from) + ' ' + drawn(middle) +
              'H' + drawn(to) + 'M' + drawn(from) + ' ' + drawn(middle - 3) + "v6M" + drawn(to) + ' ' +
              drawn(middle - 3) + "v6\"/>";
  }
  return drawn_row(bar.name, bar.text, data_attribute("data-value", bar.value), inside, y);
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

std::string figure(const Waterfall& w) {
  std::vector<double> products{w.start};
  for (const WaterfallFactor& f : w.factors) products.push_back(products.back() * f.value);
  const BarAxis a =
      bar_axis(*std::max_element(products.begin(), products.end()), {"", w.unit}, products.size() + 1);
  const auto end = [&](const std::string& name, double value, double y) {
    return drawn_row(name, readable(value, w.unit), data_attribute("data-value", value),
                     drawn_rectangle(a.at(0), a.at(value), y, 0), y);
  };
  double y = 0;
  std::string out = chart_begin(w.title, w.description, a) + end(w.first, products.front(), y);
  for (std::size_t i = 0; i < w.factors.size(); ++i) {
    const double from = products[i], to = products[i + 1], least = std::min(from, to),
                 most = std::max(from, to);
    y += row;
    // A factor of 1 is a line.
    out += drawn_row(
        w.factors[i].name, "\u00d7 " + significant(w.factors[i].value, 4),
        data_attribute("data-value", w.factors[i].value) + data_attribute("data-from", from) +
            data_attribute("data-to", to),
        drawn_rectangle(a.at(least), std::max(a.at(most), a.at(least) + 1), y, to > from ? 1 : 2), y);
  }
  return out + end(w.last, products.back(), y + row) + "</svg></figure>\n";
}

}  // namespace qerr::page
