#include "input/yaml_text.hpp"

#include <algorithm>
#include <string_view>

#include "core/text.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

bool is_plain(const std::string& text) {
  constexpr std::string_view first = "&*!|>'\"%@`#?,[]{} -:", within = ",[]{}#\"'";
  if (text.empty() || text.back() == ' ' || text.back() == ':') return false;
  if (first.find(text.front()) != std::string_view::npos && !parse_number(text)) return false;
  if (text.find(": ") != std::string::npos) return false;
  return std::none_of(text.begin(), text.end(), [&](char c) {
    return within.find(c) != std::string_view::npos || static_cast<unsigned char>(c) < 0x20;
  });
}

std::string in_double_quotes(const std::string& text) {
  const bool control =
      std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; });
  std::string out;
  for (const char c : text) {
    const bool escape = control && static_cast<unsigned char>(c) < 0x20;
    if (control && (c == '"' || c == '\\')) out += '\\';
    if (!control && c == '\'') out += '\'';
    out += escape ? "\\x" + hexadecimal(static_cast<unsigned char>(c)) : std::string(1, c);
  }
  return control ? '"' + out + '"' : '\'' + out + '\'';
}

}  // namespace

std::string flow_scalar(const std::string& text, bool in_quotes) {
  return !in_quotes && is_plain(text) ? text : in_double_quotes(text);
}

namespace {

constexpr std::size_t longest_key = 1000;  // bytes, its quotation marks included

}  // namespace

std::string block_key(const std::string& written, const std::string& indent) {
  return written.size() <= longest_key ? written + ": " : "? " + written + '\n' + indent + ": ";
}

std::string commented(const std::string& comment, const std::string& indent) {
  std::string out;
  for (std::size_t begin = 0; begin < comment.size();) {
    const std::size_t end = std::min(comment.find('\n', begin), comment.size());
    out += indent + "# " + comment.substr(begin, end - begin) + '\n';
    begin = end + 1;
  }
  return out;
}

std::string flow_key(const std::string& name) {
  const std::string written = flow_scalar(name, false);
  return written.size() <= longest_key ? written + ": " : "? " + written + " : ";
}

std::string flow(const Node& n) {
  std::string out;
  switch (n.type) {
    case Node::Type::null:
      return "null";
    case Node::Type::scalar:
      return flow_scalar(n.text, n.quoted);
    case Node::Type::sequence:
      for (const Node& item : n.items) out += (out.empty() ? "" : ", ") + flow(item);
      return '[' + out + ']';
    case Node::Type::mapping:
      for (const auto& [key, value] : n.entries)
        out += (out.empty() ? "" : ", ") + flow_key(key.name) + flow(value);
      return '{' + out + '}';
  }
  return out;
}

bool same_value(const Node& a, const Node& b) {
  if (a.type != b.type || a.text != b.text || a.items.size() != b.items.size() ||
      a.entries.size() != b.entries.size())
    return false;
  if (a.quoted != b.quoted && parse_number(a.text)) return false;
  for (std::size_t i = 0; i < a.items.size(); ++i)
    if (!same_value(a.items[i], b.items[i])) return false;
  return std::all_of(a.entries.begin(), a.entries.end(), [&](const auto& entry) {
    const Node* other = b.find(entry.key.name);
    return other && same_value(entry.value, *other);
  });
}

}  // namespace qerr
