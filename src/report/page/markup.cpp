#include "report/page/markup.hpp"

#include <algorithm>
#include <vector>

#include "core/text.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr::page {

namespace {

constexpr std::string_view replacement = "\xEF\xBF\xBD";

/// Marks that qerr sets itself (prose.hpp): U+2068 and U+2069 isolate a name, U+200E begins a text.
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

}  // namespace qerr::page
