#include "report/page/prose.hpp"

#include "report/page/markup.hpp"

namespace qerr::page {

std::string paragraph(const std::string& text) {
  return text.empty() ? "" : "<p>" + escaped_markup(text) + "</p>\n";
}

std::string list(const std::vector<std::string>& items) {
  if (items.empty()) return "";
  std::string out = "<ul>\n";
  for (const std::string& item : items) out += "<li>" + escaped_markup(item) + "</li>\n";
  return out + "</ul>\n";
}

std::string subtitle(const std::string& name) { return "<h3>" + escaped_markup(name) + "</h3>\n"; }

std::string side_by_side(const std::string& figures) {
  return figures.empty() ? "" : "<div class=\"figures\">" + figures + "</div>\n";
}

}  // namespace qerr::page
