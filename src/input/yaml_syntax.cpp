#include "input/yaml_syntax.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

namespace qerr {

namespace {

using Lines = std::vector<std::string>;

const std::string& line_at(const Lines& lines, int line) {
  static const std::string none;
  return line >= 1 && static_cast<std::size_t>(line) <= lines.size()
             ? lines[static_cast<std::size_t>(line) - 1]
             : none;
}

Place place_in(const Place& at, int line, std::size_t offset) {
  return {at.file, line, static_cast<int>(offset) + 1};
}

/// The line without its comment and trailing blanks.
std::string_view content(std::string_view line) {
  for (std::size_t i = line.find('#'); i != std::string_view::npos; i = line.find('#', i + 1))
    if (i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t') line = line.substr(0, i);
  const std::size_t last = line.find_last_not_of(" \t\r");
  return last == std::string_view::npos ? std::string_view() : line.substr(0, last + 1);
}

std::size_t indentation(std::string_view line) { return std::min(line.find_first_not_of(' '), line.size()); }

/// A tab before the first key of a line, at or before the place.
std::optional<Fault> indented_by_tab(const Lines& lines, const Place& at) {
  for (int number = 1; number <= at.line; ++number) {
    const std::string& line = line_at(lines, number);
    const std::size_t first = line.find_first_not_of(" \t"), tab = line.find('\t');
    if (first != std::string::npos && tab < first && line[first] != '#')
      return Fault{place_in(at, number, tab), "", "a tab cannot indent a line of YAML", "a tab",
                   "indent with spaces; many editors have a setting for it"};
  }
  return std::nullopt;
}

/// A key or value that begins with a character which YAML reserves.
std::optional<Fault> reserved_start(const Lines& lines, const Place& at) {
  const std::string& line = line_at(lines, at.line);
  auto column = static_cast<std::size_t>(std::max(at.column, 1)) - 1;
  if (column > 0 && column <= line.size() && line[column - 1] == '*') --column;
  if (column >= line.size() || std::string_view("*@`%").find(line[column]) == std::string_view::npos)
    return std::nullopt;
  const std::size_t end = std::min(line.find_first_of(" :,}]", column), line.size());
  const std::string word = line.substr(column, end - column);
  const Place place = place_in(at, at.line, column);
  return Fault{place, "",
               "a key or value that begins with " + word.substr(0, 1) + " must be in quotation marks",
               text_at(lines, place), "write '" + word + "' with the quotation marks"};
}

/// `bits:17` in place of `bits: 17`, on the line or the one above.
std::optional<Fault> colon_without_space(const Lines& lines, const Place& at) {
  for (const int number : {at.line, at.line - 1}) {
    const std::string_view line = content(line_at(lines, number));
    for (std::size_t i = line.find(':'); i != std::string_view::npos; i = line.find(':', i + 1)) {
      const std::size_t begin = line.find_last_of(" {,'\"", i) + 1;
      const bool key = i > begin && i + 1 < line.size() && line[i + 1] != ' ' && line[i + 1] != '\\' &&
                       line[i + 1] != '/' && line[i + 1] != ':' && line[i + 1] != '\t';
      if (key)
        return Fault{place_in(at, number, i), "", "a colon after a key must be followed by a space",
                     "'" + std::string(line.substr(begin, 40)) + "'",
                     "write '" + std::string(line.substr(begin, i - begin)) + ": " +
                         std::string(line.substr(i + 1, 20)) + "'"};
    }
  }
  return std::nullopt;
}

/// A line that is indented deeper than the value above it, or like no line above it.
std::optional<Fault> odd_indentation(const Lines& lines, const Place& at) {
  const std::string_view line = content(line_at(lines, at.line));
  int above = at.line - 1;
  while (above > 0 && content(line_at(lines, above)).empty()) --above;
  const std::string_view before = content(line_at(lines, above));
  const std::size_t own = indentation(line);
  if (line.empty() || before.empty()) return std::nullopt;
  const Place place = place_in(at, at.line, own);
  const bool has_value = before.find(": ") != std::string_view::npos;
  if (own > indentation(before) && has_value)
    return Fault{place, "", "the line is indented deeper than the one above, which has its value already",
                 text_at(lines, place),
                 "indent it like '" + std::string(before.substr(indentation(before), 40)) + "'"};
  if (own >= indentation(before)) return std::nullopt;
  // The open blocks are those of the lines above with less and less indentation.
  for (int number = above; number > 0; --number) {
    const std::string_view other = content(line_at(lines, number));
    if (other.empty()) continue;
    if (indentation(other) == own) return std::nullopt;
    if (indentation(other) < own) break;
  }
  return Fault{place, "", "the indentation of the line is that of no open mapping above it",
               text_at(lines, place), "give the keys of one mapping the same indentation"};
}

/// A line above, `encoders`, that opens a section but lacks its colon.
std::optional<Fault> key_without_colon(const Lines& lines, const Place& at) {
  for (int number = at.line; number >= 1 && number >= at.line - 2; --number) {
    const std::string_view line = content(line_at(lines, number));
    const std::size_t first = line.find_first_not_of(' ');
    if (first == std::string_view::npos) continue;
    const std::string_view word = line.substr(first);
    if (word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789") !=
        std::string_view::npos)
      continue;
    return Fault{place_in(at, number, first), "", "a key must be followed by a colon",
                 "'" + std::string(word) + "'", "write '" + std::string(word) + ":'"};
  }
  return std::nullopt;
}

/// `key: name: value`, or a text with ': ' in it that is not quoted.
std::optional<Fault> two_values(const Lines& lines, const Place& at) {
  const std::string_view line = content(line_at(lines, at.line));
  const std::size_t first = line.find(": ");
  if (first == std::string_view::npos || line.find_first_of("{[") < first) return std::nullopt;
  const std::size_t second = line.find(": ", first + 2);
  if (second == std::string_view::npos || line.find_first_of("{['\"", first) < second) return std::nullopt;
  return Fault{place_in(at, at.line, second), "", "a line has one key and one value",
               "'" + std::string(line.substr(first + 2, 40)) + "'",
               "write '" + std::string(line.substr(indentation(line), first - indentation(line))) + ": {" +
                   std::string(line.substr(first + 2, 40)) + "}', or begin a new line"};
}

std::optional<Fault> backslash(const Lines& lines, const Place& at) {
  const std::string& line = line_at(lines, at.line);
  const std::size_t slash = line.find('\\');
  if (slash == std::string::npos) return std::nullopt;
  return Fault{place_in(at, at.line, slash), "", "a backslash in double quotation marks begins an escape",
               "'" + line.substr(slash, 2) + "'", "write paths with '/', or use single quotation marks"};
}

/// A word of the parser's message, what it means, and the remedy.
struct Meaning {
  std::string_view word, rule, remedy;
};

constexpr std::array meanings{
    Meaning{"end of map flow", "a brace '{' is not closed, or a comma is missing",
            "separate entries by commas, 'key: value, key: value', and close with '}'"},
    Meaning{"end of sequence flow", "a bracket '[' is not closed, or a comma is missing",
            "separate items by commas, and close with ']'"},
    Meaning{"illegal flow end", "a closing bracket has no opening one of its kind",
            "close '{' with '}' and '[' with ']'"},
    Meaning{"illegal block entry", "a list item '- ' cannot begin here",
            "put each '- ' on a line of its own, or write [a, b]"},
    Meaning{"EOF in scalar", "a quotation mark is not closed", "close it on its line"},
    Meaning{"document indicator", "a quotation mark is not closed", "close it on its line"},
    Meaning{"tag", "a '!' begins a tag, and tags are not supported", "put the text in quotation marks"},
    Meaning{"anchor", "a '&' begins an anchor, and anchors are not supported",
            "put the text in quotation marks"},
    Meaning{"directive", "a line that begins with % is a directive, and directives are not supported",
            "remove it; a comment begins with #"},
};

}  // namespace

std::string text_at(const Lines& lines, const Place& at) {
  const std::string& line = line_at(lines, at.line);
  const auto column = static_cast<std::size_t>(std::max(at.column, 1)) - 1;
  if (column >= line.size()) return "the end of the line";
  return "'" + line.substr(column, 40) + "'";
}

Fault syntax_fault(const std::vector<std::string>& lines, const Place& at, const std::string& message) {
  const auto says = [&](std::string_view word) { return message.find(word) != std::string::npos; };
  if (auto fault = indented_by_tab(lines, at)) return *fault;
  if (says("escape") || says("unicode") || says("hex number"))
    if (auto fault = backslash(lines, at)) return *fault;
  if (auto fault = reserved_start(lines, at)) return *fault;
  if (auto fault = colon_without_space(lines, at)) return *fault;
  for (const Meaning& m : meanings)
    if (says(m.word)) return {at, "", std::string(m.rule), text_at(lines, at), std::string(m.remedy)};
  if (auto fault = two_values(lines, at)) return *fault;
  if (auto fault = key_without_colon(lines, at)) return *fault;
  if (auto fault = odd_indentation(lines, at)) return *fault;
  return {at, "", "the line does not fit the lines above it", text_at(lines, at),
          "write 'key: value', and give the keys of one mapping the same indentation"};
}

}  // namespace qerr
