#include "input/line_layout.hpp"

#include <algorithm>
#include <optional>

#include "core/text.hpp"
#include "input/log_names.hpp"

namespace qerr {

namespace {

constexpr std::size_t most_lines = 60;  // that decide; a table of other lines is none of these

bool begins_name(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_label_character(char c) {
  return begins_name(c) || (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '/' || c == '[' || c == ']';
}

struct Label {
  std::size_t begin, end;  ///< in the line, the mark behind it included
  std::string_view name;
};

/// The next `name=`, `name:` or `"name":` at or behind `at`.
std::optional<Label> next_label(std::string_view line, std::size_t at) {
  for (; at < line.size(); ++at) {
    const bool quoted = line[at] == '"';
    const std::size_t begin = at + quoted;
    if (begin >= line.size() || !begins_name(line[begin]) || (at > 0 && is_label_character(line[at - 1])))
      continue;
    std::size_t end = begin;
    while (end < line.size() && (quoted ? line[end] != '"' : is_label_character(line[end]))) ++end;
    std::size_t mark = std::min(end + quoted, line.size());
    while (mark < line.size() && line[mark] == ' ') ++mark;
    if (mark < line.size() && (line[mark] == ':' || line[mark] == '='))
      return Label{at, mark + 1, line.substr(begin, end - begin)};
    at = end;
  }
  return std::nullopt;
}

std::vector<std::string> labels_of(std::string_view line) {
  std::vector<std::string> names;
  for (auto label = next_label(line, 0); label; label = next_label(line, label->end))
    names.emplace_back(label->name);
  return names;
}

bool is_framed(std::string_view line) {
  line = trimmed(line);
  return line.size() > 2 &&
         ((line.front() == '[' && line.back() == ']') || (line.front() == '(' && line.back() == ')') ||
          (line.front() == '|' && line.back() == '|'));
}

/// `|---|---:|`
bool is_rule(std::string_view line) {
  return line.find('-') != std::string_view::npos &&
         line.find_first_not_of("|-: \r\n") == std::string_view::npos;
}

}  // namespace

LineLayout::LineLayout(std::string_view head) {
  returns_ = head.find('\n') == std::string_view::npos && std::count(head.begin(), head.end(), '\r') > 1;
  std::vector<std::string_view> lines;
  for (std::size_t at = 0; at < head.size() && lines.size() < most_lines;) {
    const std::size_t end = head.find(line_end(), at);
    if (end == std::string_view::npos) break;  // cut off
    if (const std::string_view line = trimmed(head.substr(at, end - at)); !line.empty() && line[0] != '#')
      lines.push_back(line);
    at = end + 1;
  }
  if (lines.size() < 2) return;
  const auto all = [&](auto&& holds) { return std::all_of(lines.begin(), lines.end(), holds); };
  std::vector<std::string> labels = labels_of(lines.front());
  if (labels.size() > 1 && all([&](std::string_view line) { return labels_of(line) == labels; }))
    labels_ = std::move(labels);
  else
    framed_ = all(is_framed);
  const auto arrow_at = [](std::string_view line) { return line.find("->"); };
  if (all([&](std::string_view line) { return arrow_at(line) != std::string_view::npos; })) {
    const std::string_view cells = lines.back().substr(arrow_at(lines.back()) + 2);
    arrow_ = ' ';
    for (const char mark : {',', ';', '\t'})
      if (cells.find(mark) != std::string_view::npos) arrow_ = mark;
    // The monitor's stamps, beside those of the board.
    const bool own = std::any_of(labels_.begin(), labels_.end(), is_time_name);
    if (!labels_.empty()) labels_.insert(labels_.begin(), own ? "received" : "timestamp");
  }
}

std::string LineLayout::description() const {
  std::string text = returns_ ? "lines end with carriage returns" : "";
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (!labels_.empty()) add("a label before each value");
  if (framed_) add("rows between brackets or pipes");
  if (arrow_ != '\0') add("stamps before ->");
  return text;
}

void LineLayout::make_plain(char* begin, char* end) const {
  if (returns_) std::replace(begin, end, '\r', '\n');
  const std::string_view line(begin, static_cast<std::size_t>(end - begin));
  if (arrow_ != '\0')
    if (const std::size_t at = line.find("->"); at != std::string_view::npos)
      begin[at] = ' ', begin[at + 1] = arrow_;
  for (auto label = labels_.empty() ? std::nullopt : next_label(line, 0); label;
       label = next_label(line, label->end))
    std::fill(begin + label->begin, begin + label->end, ' ');
  if (!labels_.empty())
    for (char* p = begin; p != end; ++p)
      if (*p == '{' || *p == '}') *p = ' ';
  if (!framed_) return;
  if (is_rule(line)) {
    std::replace_if(
        begin, end, [](char c) { return c != '\n'; }, ' ');
    return;
  }
  const std::string_view inner = trimmed(line);
  if (inner.size() < 2) return;
  char *const first = begin + (inner.data() - line.data()), *const last = first + inner.size() - 1;
  if (*first == '|') std::replace(first + 1, last, '|', ';');
  *first = *last = ' ';
}

}  // namespace qerr
