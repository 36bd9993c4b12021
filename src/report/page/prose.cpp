#include "report/page/prose.hpp"

#include <algorithm>

#include "core/text.hpp"
#include "report/page/markup.hpp"
#include "report/page/page.hpp"

namespace qerr::page {

namespace {

/// Letters of scripts that are written from the right (Unicode's blocks of Bidi_Class R and AL).
bool from_the_right(unsigned code) {
  return (code >= 0x590 && code <= 0x8FF) || (code >= 0xFB1D && code <= 0xFDFF) ||
         (code >= 0xFE70 && code <= 0xFEFC) || (code >= 0x10800 && code <= 0x10FFF) ||
         (code >= 0x1E800 && code <= 0x1EFFF);
}

bool between_words(char c) { return c == ' ' || c == '_' || c == '-'; }

}  // namespace

std::string isolated_runs(const std::string& text) {
  std::string out;
  std::size_t run = std::string::npos;  // its first byte in `out`
  std::size_t end = 0;                  // of its last letter in `out`
  bool any = false;
  const auto close = [&] {
    if (run == std::string::npos) return;
    out.insert(end, "\u2069");
    out.insert(run, "\u2068");
    run = std::string::npos;
  };
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = std::max<std::size_t>(1, utf8_length(text, at));
    const bool right = length > 1 && from_the_right(code_point(text, at));
    if (!right && !between_words(text[at])) close();
    if (right && run == std::string::npos) run = out.size();
    out.append(text, at, length);
    if (right) end = out.size(), any = true;
    at += length;
  }
  close();
  return any ? "\u200E" + out : out;
}

std::string isolated(const std::string& name) { return "\u2068" + name + "\u2069"; }

std::string paragraph(const std::string& text) {
  return text.empty() ? "" : "<p>" + escaped_markup(isolated_runs(text)) + "</p>\n";
}

std::string list(const std::vector<std::string>& items) {
  if (items.empty()) return "";
  std::string out = "<ul>\n";
  for (const std::string& item : items) out += "<li>" + escaped_markup(isolated_runs(item)) + "</li>\n";
  return out + "</ul>\n";
}

std::string subtitle(const std::string& name) {
  return "<h3>" + escaped_markup(isolated_runs(name)) + "</h3>\n";
}

AxisRange time_axis(double last) { return {"time", "s", false, last < 1}; }

std::string side_by_side(const std::string& figures) {
  return figures.empty() ? "" : "<div class=\"figures\">" + figures + "</div>\n";
}

}  // namespace qerr::page
