#include "report/csv_text.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

/// Whether a spreadsheet would calculate the text, or an apostrophe before it would be taken for one of ours.
bool is_formula(const std::string& text) {
  std::string why;
  return text.size() > 1 && std::string_view("=+-@'").find(text[0]) != std::string_view::npos &&
         !parse_quantity(text, why);
}

/// Whether the text means itself without quotation marks: blanks at its ends are lost, and `#` begins a
/// comment.
bool is_plain(const std::string& text) {
  return text.empty() || (text.find_first_of(",\"\r\n") == std::string::npos && text[0] != '#' &&
                          text.front() != ' ' && text.back() != ' ');
}

}  // namespace

std::string csv_cell(const std::string& cell) {
  const std::string text = (is_formula(cell) ? "'" : "") + escaped(cell, std::string::npos);
  if (is_plain(text)) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

std::string csv_number(double value) {
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return std::isnan(value) ? std::string() : shortest(value);
}

std::string csv_number(const std::optional<double>& value) {
  return value ? csv_number(*value) : std::string();
}

std::string csv_cells(const Json& object, const std::vector<std::string>& paths) {
  std::string cells;
  for (const std::string& path : paths) {
    const Json* value = &object;
    for (std::size_t begin = 0; value && begin <= path.size();) {
      const std::size_t dot = std::min(path.find('.', begin), path.size());
      value = value->find(std::string_view(path).substr(begin, dot - begin));
      begin = dot + 1;
    }
    if (&path != &paths.front()) cells += ',';
    if (!value) continue;
    if (const std::optional<bool> truth = value->boolean())
      cells += *truth ? "true" : "false";
    else
      cells += value->text() ? csv_cell(*value->text()) : csv_number(value->number());
  }
  return cells;
}

std::vector<std::string> csv_paths(const Json& schema) {
  std::vector<std::string> paths;
  for (const auto& [name, member] : schema.find("properties")->members()) {
    if (!member.find("properties")) paths.push_back(name);
    if (member.find("properties"))
      for (const std::string& inner : csv_paths(member)) paths.push_back(name + '.' + inner);
  }
  return paths;
}

}  // namespace qerr
