#include "report/page/page.hpp"

#include <algorithm>

#include "core/text.hpp"

namespace qerr::page {

std::string json_script(std::string json, const std::string& attributes) {
  for (std::size_t i = 0; (i = json.find_first_of("<>&", i)) != std::string::npos;)
    json.replace(i, 1, json[i] == '<' ? "\\u003c" : json[i] == '>' ? "\\u003e" : "\\u0026");
  return "<script type=\"application/json\"" + attributes + '>' + json + "</script>";
}

std::string bar_cell(const std::string& text, double part, double value, int colour) {
  return "<td class=\"use " + (part > 1 ? "over" : 's' + std::to_string(colour)) + '"' +
         data_attribute("data-value", value) +
         " style=\"--p:" + significant(100 * std::clamp(part, 0.0, 1.0), 4) + "%\">" + escaped_markup(text) +
         "</td>";
}

std::string cell(const std::string& text) { return "<td>" + name_markup(text) + "</td>"; }

std::string table_of(std::string_view style, const std::vector<std::string>& header,
                     const std::vector<std::string>& rows) {
  std::string out = "<div class=\"wide\"><table class=\"" + std::string(style) + "\"><thead><tr>";
  for (const std::string& head : header)
    out += "<th scope=\"col\">" + escaped_markup(isolated_runs(head)) + "</th>";
  out += "</tr></thead><tbody>\n";
  for (const std::string& row : rows) out += "<tr>" + row + "</tr>\n";
  return out + "</tbody></table></div>\n";
}

std::string table(const std::vector<std::string>& header, const TableRows& rows) {
  std::vector<std::string> marked;
  for (const auto& row : rows) {
    marked.emplace_back();
    for (const std::string& text : row) marked.back() += cell(isolated_runs(text));
  }
  return table_of("plain", header, marked);
}

std::string table(TableRows rows, const std::string& corner) {
  std::vector<std::string> header = std::move(rows.front());
  if (header.front().empty()) header.front() = corner;
  rows.erase(rows.begin());
  return table(header, rows);
}

std::string title_list(const std::vector<std::pair<std::string, std::string>>& entries) {
  std::string out = "<div class=\"head\"><dl class=\"about\">";
  for (const auto& [name, text] : entries) out += "<dt>" + name + "</dt><dd>" + text + "</dd>";
  return out + "</dl>";
}

std::string choice(const std::string& label,
                   const std::vector<std::pair<std::string, std::string>>& figures) {
  std::string out = "<div class=\"choice\">";
  if (figures.size() > 1) {
    out += "<label hidden=\"hidden\">" + escaped_markup(label) + " <select>";
    for (const auto& [name, body] : figures) out += "<option>" + escaped_markup(name) + "</option>";
    out += "</select></label>";
  }
  for (const auto& [name, body] : figures) out += "<div class=\"option\">" + body + "</div>\n";
  return out + "</div>\n";
}

std::string markup(const Page& page) {
  std::string out =
      "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\"><head><meta "
      "charset=\"utf-8\"/>"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/><title>" +
      escaped_markup(page.title) + "</title><style>" + std::string(style_sheet) +
      "</style></head><body><main>\n<h1>" + name_markup(page.title) + "</h1>\n<p class=\"answer\">" +
      escaped_markup(page.answer) + "</p>\n" + page.about + "<div class=\"sections\">\n";
  for (const PageSection& s : page.sections)
    out += "<section><h2>" + escaped_markup(s.heading) + "</h2>\n" + s.body + "</section>\n";
  if (!page.warnings.empty()) {
    out += "<section><h2>Warnings and assumptions</h2><ul>\n";
    for (const std::string& w : page.warnings) out += "<li>" + escaped_markup(w) + "</li>\n";
    out += "</ul></section>\n";
  }
  out += "</div>\n";
  if (!page.spec_text.empty())
    out += "<details><summary>Spec " + name_markup(page.spec_file) + "</summary><pre>" +
           escaped_markup(page.spec_text) + "</pre></details>\n";
  if (!page.report.empty()) out += json_script(page.report, " id=\"report\"");
  return out + "</main><script>//<![CDATA[\n" + std::string(script) + "//]]></script></body></html>\n";
}

std::size_t bytes_left(const Page& page) {
  // Some texts are given without the entities and elements around them: a reserve of 25 kB.
  constexpr std::size_t most = 275000, fewest = 40000;
  std::size_t taken = page.answer.size() + page.about.size() + page.spec_text.size();
  for (const PageSection& s : page.sections) taken += s.heading.size() + s.body.size();
  for (const std::string& w : page.warnings) taken += w.size();
  return most > taken + fewest ? most - taken : fewest;
}

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
