#include <algorithm>
#include <string_view>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/yaml_tree.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

bool is_plain(const std::string& text) {
  constexpr std::string_view first = "&*!|>'\"%@`#?,[]{} -:", within = ",[]{}#\"'";
  if (text.empty() || text.back() == ' ' || text.back() == ':') return false;
  if (first.find(text.front()) != std::string_view::npos && !parse_number(text)) return false;
  if (text.find(": ") != std::string::npos) return false;
  return std::ranges::none_of(text, [&](char c) {
    return within.find(c) != std::string_view::npos || static_cast<unsigned char>(c) < 0x20;
  });
}

std::string in_double_quotes(const std::string& text) {
  const bool control = std::ranges::any_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x20; });
  std::string out;
  for (const char c : text) {
    const bool escape = control && static_cast<unsigned char>(c) < 0x20;
    if (control && (c == '"' || c == '\\')) out += '\\';
    if (!control && c == '\'') out += '\'';
    out += escape ? "\\x" + hexadecimal(static_cast<unsigned char>(c)) : std::string(1, c);
  }
  return control ? '"' + out + '"' : '\'' + out + '\'';
}

constexpr std::size_t longest_key = 1000;  // bytes, its quotation marks included

/// A key in such a line, with its colon.
std::string flow_key(const std::string& name) {
  const std::string written = flow_scalar(name, false);
  return written.size() <= longest_key ? written + ": " : "? " + written + " : ";
}

/// @param same  of two values, as far as it decides
template <class Same>
bool same_nodes(const Node& a, const Node& b, const Same& same) {
  if (const std::optional<bool> decided = same(a, b)) return *decided;
  if (a.type != b.type || a.text != b.text || a.items.size() != b.items.size() ||
      a.entries.size() != b.entries.size())
    return false;
  for (std::size_t i = 0; i < a.items.size(); ++i)
    if (!same_nodes(a.items[i], b.items[i], same)) return false;
  return std::ranges::all_of(a.entries, [&](const auto& entry) {
    const Node* other = b.find(entry.key.name);
    return other && same_nodes(entry.value, *other, same);
  });
}

bool same_value(const Node& a, const Node& b) {
  return same_nodes(a, b, [](const Node& x, const Node& y) {
    return x.quoted != y.quoted && parse_number(x.text) ? std::optional(false) : std::nullopt;
  });
}

using std::size_t;

constexpr std::string_view blanks = " \t\r";

/// Edits of a text, collected while the present and the wanted tree are compared.
class Rewriter {
 public:
  Rewriter(const std::string& text, std::string file, const std::vector<std::string>& replaced)
      : text_(text), file_(std::move(file)), replaced_(replaced) {
    for (size_t at = 0; at != std::string::npos && at <= text_.size();) {
      lines_.push_back(at);
      at = text_.find('\n', at);
      if (at != std::string::npos) ++at;
    }
  }

  void compare(const Node& have, const Node& want, const std::string& path) {
    if (have.type != want.type) return replace(have, want, path);
    if (have.type == Node::Type::mapping) return compare_mappings(have, want, path);
    if (have.type == Node::Type::sequence) return compare_lists(have, want, path);
    if (!same_value(have, want)) replace(have, want, path);
  }

  std::string result() {
    // From the end, so that earlier offsets stay valid; edits at one offset keep their order.
    std::ranges::stable_sort(edits_, [](const Edit& a, const Edit& b) { return a.at < b.at; });
    std::string out = text_;
    for (auto e = edits_.rbegin(); e != edits_.rend(); ++e) out.replace(e->at, e->length, e->text);
    return out;
  }

 private:
  struct Edit {
    size_t at, length;
    std::string text;
  };

  [[noreturn]] void refuse(const Node& node, const std::string& path) const {
    throw Error(node.place, path, "the layout of the spec does not allow changing this value", "",
                "write the change into the spec itself");
  }

  size_t offset(const Place& p) const {
    if (p.line < 1 || static_cast<size_t>(p.line) > lines_.size()) return text_.size();
    return std::min(lines_[static_cast<size_t>(p.line) - 1] + static_cast<size_t>(std::max(p.column, 1)) - 1,
                    text_.size());
  }
  bool starts_with(const Node& n, char c) const {
    const size_t at = offset(n.place);
    return at < text_.size() && text_[at] == c;
  }
  bool is_flow(const Node& n) const { return starts_with(n, '[') || starts_with(n, '{'); }
  size_t line_start(size_t at) const { return at == 0 ? 0 : text_.rfind('\n', at - 1) + 1; }
  size_t line_end(size_t at) const { return std::min(text_.find('\n', at), text_.size()); }

  std::string indent(size_t at) const {
    const size_t start = line_start(at);
    return text_.substr(start, std::min(text_.find_first_not_of(blanks, start), text_.size()) - start);
  }

  /// The offset after the quotation mark that closes the one at `at`.
  size_t after_quote(size_t at) const {
    const char quote = text_[at++];
    while (at < text_.size() && text_[at] != quote) at += quote == '"' && text_[at] == '\\' ? 2 : 1;
    return std::min(at + 1, text_.size());
  }

  /// The offset of the bracket that closes the one at `at`, and the last character of content before it.
  std::pair<size_t, char> closing(size_t at, const Node& node, const std::string& path) const {
    int depth = 0;
    char last = 0;
    for (; at < text_.size(); ++at) {
      const char c = text_[at];
      if (blanks.find(c) != std::string_view::npos || c == '\n') continue;
      if (c == '#' && at > 0 &&
          (blanks.find(text_[at - 1]) != std::string_view::npos || text_[at - 1] == '\n')) {
        at = line_end(at);
        continue;
      }
      if ((c == ']' || c == '}') && --depth == 0) return {at, last};
      if (c == '[' || c == '{') ++depth;
      if ((c == '\'' || c == '"') && std::string_view("[{,:").find(last) != std::string_view::npos)
        at = after_quote(at) - 1;
      last = c;
    }
    refuse(node, path);
  }

  /// The offset after a scalar or a value in brackets.
  size_t end_of(const Node& n, const std::string& path) const {
    const size_t at = offset(n.place);
    if (is_flow(n)) return closing(at, n, path).first + 1;
    if (n.type != Node::Type::scalar) refuse(n, path);
    if (n.quoted && at < text_.size() && (text_[at] == '"' || text_[at] == '\'')) return after_quote(at);
    if (text_.compare(at, n.text.size(), n.text) != 0) refuse(n, path);
    return at + n.text.size();
  }

  void replace(const Node& have, const Node& want, const std::string& path) {
    // A value in block style gives way to one in one line below its key.
    const bool in_lines =
        !is_flow(have) && (have.type == Node::Type::mapping || have.type == Node::Type::sequence);
    const size_t end = in_lines ? last_line(have, path) : end_of(have, path), at = offset(have.place);
    edits_.push_back({at, end - at, flow(want)});
  }

  /// The end of the last line of a value.
  size_t last_line(const Node& n, const std::string& path) const {
    if (n.type == Node::Type::null) return line_end(offset(n.place));
    if (n.type == Node::Type::scalar || is_flow(n)) return line_end(end_of(n, path));
    size_t last = offset(n.place);
    for (const Node& item : n.items) last = std::max(last, last_line(item, path));
    for (const auto& [key, value] : n.entries)
      last = std::max({last, line_end(offset(key.place)), last_line(value, path)});
    return last;
  }

  void compare_mappings(const Node& have, const Node& want, const std::string& path) {
    for (const auto& [key, value] : have.entries)
      if (!want.find(key.name)) return replace(have, want, path);
    for (const auto& [key, value] : want.entries) {
      const std::string below = path.empty() ? key.name : path + '.' + key.name;
      if (const Node* old = have.find(key.name))
        compare(*old, value, below);
      else
        add_key(have, key.name, value, below);
    }
    for (const auto& [key, value] : have.entries) {
      const std::string below = path.empty() ? key.name : path + '.' + key.name;
      const bool replaced = contains(replaced_, below);
      if (replaced && !same_value(value, *want.find(key.name))) drop_comments(key, value, below);
    }
  }

  /// Removes the comments on the lines of an entry, and those directly above it at its indent: they describe
  /// what is replaced.
  void drop_comments(const Node::Key& key, const Node& value, const std::string& path) {
    const size_t begin = offset(key.place), end = last_line(value, path);
    for (size_t line = line_start(begin); line < end; line = line_end(line) + 1)
      if (const size_t from = comment_in(line); from < line_end(line)) erase(from, line_end(line));
    const std::string lead = text_.substr(line_start(begin), begin - line_start(begin));
    if (lead.find_first_not_of(' ') != std::string::npos) return;
    size_t first = line_start(begin);
    while (first > 0 && text_.compare(line_start(first - 1), lead.size() + 1, lead + '#') == 0)
      first = line_start(first - 1);
    if (first < line_start(begin)) erase(first, line_start(begin));
  }

  /// Where the comment of a line begins, with the blanks before it; the line's end without one.
  size_t comment_in(size_t line) const {
    const size_t end = line_end(line);
    char last = ':';  // what precedes a quotation mark that opens
    for (size_t at = line; at < end; ++at) {
      const char c = text_[at];
      const bool blank = blanks.find(c) != std::string_view::npos;
      if (c == '#' && at > line && blanks.find(text_[at - 1]) != std::string_view::npos) {
        const size_t before = text_.find_last_not_of(blanks, at - 1);
        return before == std::string::npos ? line : std::max(line, before + 1);
      }
      if ((c == '\'' || c == '"') && std::string_view("[{,:-").find(last) != std::string_view::npos)
        at = std::min(after_quote(at), end) - 1;
      if (!blank) last = c;
    }
    return end;
  }

  /// Unless another edit covers it.
  void erase(size_t from, size_t to) {
    const bool covered = std::ranges::any_of(
        edits_, [&](const Edit& e) { return e.length > 0 && e.at < to && from < e.at + e.length; });
    if (!covered) edits_.push_back({from, to - from, ""});
  }

  void compare_lists(const Node& have, const Node& want, const std::string& path) {
    if (want.items.size() < have.items.size() || have.items.empty()) {
      if (!same_value(have, want)) replace_list(have, want, path);
      return;
    }
    for (size_t i = 0; i < have.items.size(); ++i)
      compare(have.items[i], want.items[i], path + '[' + std::to_string(i) + ']');
    for (size_t i = have.items.size(); i < want.items.size(); ++i) add_item(have, want.items[i], path);
  }

  /// Fills an empty list within its brackets; replaces a longer list.
  void replace_list(const Node& have, const Node& want, const std::string& path) {
    if (!have.items.empty()) return replace(have, want, path);
    for (const Node& item : want.items) add_item(have, item, path);
  }

  void add_key(const Node& have, const std::string& key, const Node& value, const std::string& path) {
    const size_t at = offset(have.place);
    if (starts_with(have, '{'))
      return add_in_brackets(have, value.comment, flow_key(key) + flow(value), path);
    if (have.entries.empty()) refuse(have, path);
    const size_t first = offset(have.entries.front().key.place);
    const std::string lead = text_.substr(line_start(first), first - line_start(first));
    if (lead.find_first_not_of(' ') != std::string::npos) refuse(have, path);
    std::string name = block_key(flow_scalar(key, false), lead);
    name.pop_back();
    if (have.place.line > 0 && path.find('.') == std::string::npos)
      return append_to_document(have, commented(value.comment, lead) + lead + name + block(value, lead));
    edits_.push_back({line_start(at), 0, commented(value.comment, lead) + lead + name + block(value, lead)});
  }

  /// A value after its key in block style: a list of mappings with one line per item, any other value in one
  /// line.
  static std::string block(const Node& value, const std::string& lead) {
    const bool lines = value.type == Node::Type::sequence && !value.items.empty() &&
                       value.items.front().type == Node::Type::mapping;
    if (!lines) return ' ' + flow(value) + '\n';
    std::string out = "\n";
    for (const Node& item : value.items)
      out += commented(item.comment, lead + "  ") + lead + "  - " + flow(item) + '\n';
    return out;
  }

  /// Adds lines at the end of the text, or before the line that ends the document.
  void append_to_document(const Node& root, const std::string& lines) {
    size_t end = text_.size();
    for (const size_t start : lines_)
      if (start > last_line(root, "") && text_.compare(start, 3, "...") == 0) end = std::min(end, start);
    const bool open_line = end > 0 && text_[end - 1] != '\n' && edits_at(end) == 0;
    edits_.push_back({end, 0, (open_line ? "\n" : "") + lines});
  }

  size_t edits_at(size_t at) const {
    return static_cast<size_t>(
        std::ranges::count_if(edits_, [&](const Edit& e) { return e.at == at && e.length == 0; }));
  }

  void add_item(const Node& have, const Node& item, const std::string& path) {
    if (starts_with(have, '[')) return add_in_brackets(have, item.comment, flow(item), path);
    const size_t first = offset(have.items.front().place);
    const size_t dash = first == 0 ? std::string::npos : text_.find_last_not_of(" \t\r\n", first - 1);
    if (dash == std::string::npos || text_[dash] != '-') refuse(have, path);
    const std::string lead = text_.substr(line_start(dash), dash - line_start(dash));
    if (lead.find_first_not_of(' ') != std::string::npos) refuse(have, path);
    const size_t end = last_line(have, path);
    const bool closed = end < text_.size();
    const std::string lines = commented(item.comment, lead) + lead + "- " + flow(item);
    edits_.push_back({closed ? end + 1 : end, 0, closed ? lines + '\n' : '\n' + lines});
  }

  void add_in_brackets(const Node& have, const std::string& comment, const std::string& value,
                       const std::string& path) {
    const auto [end, last] = closing(offset(have.place), have, path);
    const bool first = (last == ',' || last == '[' || last == '{') && edits_at(end) == 0;
    const std::string lead = indent(offset(have.place)) + "  ";
    edits_.push_back({end, 0,
                      std::string(first ? "" : ",") +
                          (comment.empty() ? (first ? "" : " ") : '\n' + commented(comment, lead) + lead) +
                          value});
  }

  const std::string& text_;
  std::string file_;
  const std::vector<std::string>& replaced_;
  std::vector<size_t> lines_;
  std::vector<Edit> edits_;
};

}  // namespace

std::string flow_scalar(const std::string& text, bool in_quotes) {
  return !in_quotes && is_plain(text) ? text : in_double_quotes(text);
}

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

bool same_meaning(const Node& a, const Node& b) {
  return same_nodes(a, b, [](const Node& x, const Node& y) {
    std::string why;
    const auto quantity = [&](const Node& n) {
      return n.type == Node::Type::scalar && !n.quoted ? parse_quantity(n.text, why) : std::nullopt;
    };
    const auto u = quantity(x), v = quantity(y);
    return u && v ? std::optional(u->value == v->value) : std::nullopt;
  });
}

std::string rewritten(const std::string& text, const Node& wanted, const std::string& file,
                      const std::vector<std::string>& replaced) {
  Rewriter rewriter(text, file, replaced);
  const Node have = parse_yaml(text, file);
  rewriter.compare(have, wanted, "");
  const std::string result = rewriter.result();
  if (!same_value(parse_yaml(result, file), wanted))
    throw Error(have.place, "", "the layout of the spec does not allow these changes", "",
                "write them into the spec itself");
  return result;
}

}  // namespace qerr
