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

namespace {

constexpr double fall_width = 400, fall_row = 30, fall_margin = 2;

struct Piece {
  std::string name, text;
  double from, to;   ///< [SI]
  std::string data;  ///< attributes
};

std::vector<Piece> pieces_of(const Waterfall& w) {
  double value = w.start;
  std::vector<Piece> all{{w.first, readable(value, w.unit), 0, value, data_attribute("data-value", value)}};
  for (const WaterfallFactor& f : w.factors) {
    const double next = value * f.value;
    all.push_back({f.name, "\u00d7 " + significant(f.value, 4), value, next,
                   data_attribute("data-value", f.value) + data_attribute("data-from", value) +
                       data_attribute("data-to", next)});
    value = next;
  }
  all.push_back({w.last, readable(value, w.unit), 0, value, data_attribute("data-value", value)});
  return all;
}

std::string drawn_piece(const Piece& p, double y, double scale) {
  const double from = fall_margin + std::min(p.from, p.to) * scale;
  // A factor of 1 is a line.
  const double length = std::max(std::abs(p.to - p.from) * scale, 1.0);
  return "<g class=\"row\" data-name=\"" + escaped_markup(p.name) + '"' + p.data + "><text x=\"2\" y=\"" +
         drawn(y + 11) + "\">" + escaped_markup(p.name) + "</text><text class=\"end\" x=\"" +
         drawn(fall_width - fall_margin) + "\" y=\"" + drawn(y + 11) + "\">" + escaped_markup(p.text) +
         "</text><rect class=\"bar\" x=\"" + drawn(from) + "\" y=\"" + drawn(y + 15) + "\" width=\"" +
         drawn(length) + "\" height=\"9\"/></g>";
}

}  // namespace

std::string figure(const Waterfall& w) {
  const std::vector<Piece> pieces = pieces_of(w);
  double largest = 0;
  for (const Piece& p : pieces) largest = std::max({largest, p.from, p.to});
  const double scale = (fall_width - 2 * fall_margin) / (largest > 0 ? largest : 1);
  std::string out = "<figure><figcaption>" + escaped_markup(w.title) +
                    "</figcaption><svg role=\"img\" viewBox=\"0 0 " + fixed_point(fall_width, 0) + ' ' +
                    fixed_point(fall_row * static_cast<double>(pieces.size()), 0) +
                    "\" xmlns=\"http://www.w3.org/2000/svg\"><title>" + escaped_markup(w.title) +
                    "</title><desc>" + escaped_markup(w.description) + "</desc>";
  double y = 0;
  for (const Piece& p : pieces) out += drawn_piece(p, y, scale), y += fall_row;
  return out + "</svg></figure>\n";
}

}  // namespace qerr::page
