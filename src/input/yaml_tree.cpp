#include "input/yaml_tree.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <sstream>

namespace qerr {

namespace {

constexpr std::size_t most_levels = 64;  // of nesting; the format of a spec has 6

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

std::optional<Fault> backslash(const Lines& lines, const Place& at) {
  const std::string& line = line_at(lines, at.line);
  const std::size_t slash = line.find('\\');
  if (slash == std::string::npos) return std::nullopt;
  return Fault{place_in(at, at.line, slash), "", "a backslash in double quotation marks begins an escape",
               "'" + line.substr(slash, 2) + "'", "write paths with '/', or use single quotation marks"};
}

/// What is written at a place, for messages: up to 40 bytes of the line, in quotation marks.
std::string text_at(const Lines& lines, const Place& at) {
  const std::string& line = line_at(lines, at.line);
  const auto column = static_cast<std::size_t>(std::max(at.column, 1)) - 1;
  if (column >= line.size()) return "the end of the line";
  return "'" + line.substr(column, 40) + "'";
}

/// Builds the tree from yaml-cpp's events, so that the depth is bounded during reading, not after it.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(const std::string& text, std::string file) : file_(std::move(file)) {
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines_.push_back(line);
  }

  Node take() { return std::move(root_); }
  bool empty() const { return !any_; }
  Place place(const YAML::Mark& mark) const {
    return mark.is_null() ? Place{file_, 0, 0} : Place{file_, mark.line + 1, mark.column + 1};
  }

  const std::vector<std::string>& lines() const { return lines_; }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuse_anchor(mark, anchor);
    add(Node{Node::Type::null, place(mark), {}, false, {}, {}});
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    throw Error(place(mark), "", "aliases are not supported", "an alias ('*name')", "write the value out");
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    refuse_anchor(mark, anchor);
    const bool quoted = tag == "!";
    if (!quoted) refuse_tag(mark, tag);
    if (!quoted) refuse_typographic_quotes(mark, value);
    refuse_control_characters(mark, value);
    refuse_several_lines(mark, value, quoted);
    add(Node{Node::Type::scalar, place(mark), value, quoted, {}, {}});
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, Node::Type::sequence);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, Node::Type::mapping);
  }
  void OnMapEnd() override { close(); }

 private:
  /// A container that is being filled; a mapping expects a key or the value of `key`.
  struct Open {
    Node node;
    bool has_key = false;
    Node::Key key;
    std::map<std::string, int> keys = {};  ///< with their lines
  };

  void refuse_anchor(const YAML::Mark& mark, YAML::anchor_t anchor) const {
    if (anchor != 0)
      throw Error(place(mark), "", "anchors are not supported", "an anchor ('&name')", "write the value out");
  }

  void refuse_tag(const YAML::Mark& mark, const std::string& tag) const {
    if (!tag.empty() && tag != "?" && tag != "!")
      throw Error(place(mark), "", "tags are not supported", text_at(lines_, place(mark)),
                  "leave the tag out");
  }

  /// An escape such as "\e" or, in the path of another system, "\r": no value of a spec has one.
  void refuse_control_characters(const YAML::Mark& mark, const std::string& value) const {
    if (escaped(value, std::string::npos) == value || value.find('\n') != std::string::npos) return;
    throw Error(place(mark), "", "a text must not contain control or invisible characters", "'" + value + "'",
                "in double quotation marks a backslash begins an escape: use single ones, or '/' in paths");
  }

  void refuse_typographic_quotes(const YAML::Mark& mark, const std::string& value) const {
    for (const std::string_view quote : {"\u2018", "\u2019", "\u201C", "\u201D", "\u201E", "\u00B4", "`"})
      if (value.starts_with(quote))
        throw Error(place(mark), "", "typographic quotation marks do not quote", "'" + value + "'",
                    "write the plain ' or \"");
  }

  /// In yaml-cpp a missing closing quotation mark extends the value to the end of the file; no value of a
  /// spec needs a second line.
  void refuse_several_lines(const YAML::Mark& mark, const std::string& value, bool quoted) const {
    const auto line = static_cast<std::size_t>(mark.line);
    if (quoted && line < lines_.size()) {
      const std::string& text = lines_[line];
      const auto column = static_cast<std::size_t>(mark.column);
      const char quote = column < text.size() ? text[column] : '\0';
      if (quote == '"' || quote == '\'') {
        std::size_t i = column + 1;
        while (i < text.size() && text[i] != quote) i += quote == '"' && text[i] == '\\' ? 2 : 1;
        if (i >= text.size())
          throw Error(place(mark), "", "a quotation mark is not closed on its line", "",
                      "end the text with " + std::string(1, quote));
      }
    }
    if (value.find('\n') != std::string::npos)
      throw Error(place(mark), "", "a value extends over several lines", "", "keep it on one line");
  }

  void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, Node::Type type) {
    refuse_anchor(mark, anchor);
    refuse_tag(mark, tag);
    if (stack_.size() >= most_levels)
      throw Error(place(mark), "", "values are nested too deeply", "",
                  "at most " + std::to_string(most_levels) + " levels");
    stack_.push_back({Node{type, place(mark), {}, false, {}, {}}, false, {}, {}});
  }

  void close() {
    Node node = std::move(stack_.back().node);
    stack_.pop_back();
    add(std::move(node));
  }

  void add(Node node) {
    any_ = true;
    if (stack_.empty()) {
      root_ = std::move(node);
      return;
    }
    Open& top = stack_.back();
    if (top.node.type == Node::Type::sequence) {
      top.node.items.push_back(std::move(node));
    } else if (!top.has_key) {
      read_key(top, node);
    } else {
      if (node.type == Node::Type::null)
        node.place = top.key.place;  // yaml-cpp gives the place of the next token
      top.node.entries.push_back({std::move(top.key), std::move(node)});
      top.has_key = false;
    }
  }

  void read_key(Open& top, const Node& node) {
    if (node.type != Node::Type::scalar)
      throw Error(node.place, "", "a key must be plain text", described(node), "write 'key: value'");
    if (node.text == "<<" && !node.quoted)
      throw Error(node.place, "<<", "merge keys are not supported", "'<<'", "write the values out");
    const auto [first, is_new] = top.keys.emplace(node.text, node.place.line);
    if (!is_new)
      throw Error(node.place, node.text, "duplicate key, already in line " + std::to_string(first->second),
                  "'" + node.text + "'", "keep one of them");
    top.key = {node.text, node.place};
    top.has_key = true;
  }

  std::string file_;
  std::vector<std::string> lines_;
  std::vector<Open> stack_;
  Node root_;
  bool any_ = false;
};

/// The line without its comment and trailing blanks.
std::string_view content(std::string_view line) {
  for (std::size_t i = line.find('#'); i != std::string_view::npos; i = line.find('#', i + 1))
    if (i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t') line = line.substr(0, i);
  const std::size_t last = line.find_last_not_of(" \t\r");
  return last == std::string_view::npos ? std::string_view() : line.substr(0, last + 1);
}

/// The line that ends the first document: the first `---` or `...` after some content.
Place second_document(const std::vector<std::string>& lines, const std::string& file) {
  bool content = false;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const bool marker = lines[i].starts_with("---") || lines[i].starts_with("...");
    if (content && marker) return {file, static_cast<int>(i) + 1, 1};
    content = content || (!marker && !lines[i].empty() && lines[i][0] != '#');
  }
  return {file, 1, 1};
}

/// Line ends and lines that yaml-cpp takes for something else than their writer: it reads a lone carriage
/// return as a blank, and ends the document at a line that begins with %, ignoring what follows.
void refuse_odd_lines(const std::vector<std::string>& lines, const std::string& file) {
  bool content = false;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const int number = static_cast<int>(i) + 1;
    const std::size_t cr = lines[i].find('\r');
    if (cr != std::string::npos && cr + 1 < lines[i].size())
      throw Error({file, number, static_cast<int>(cr) + 1}, "", "a carriage return without a line feed", "",
                  "end lines with LF or CR LF");
    if (content && lines[i].starts_with('%'))
      throw Error({file, number, 1}, "", "a line must not begin with %", "'" + lines[i].substr(0, 40) + "'",
                  "a comment begins with #");
    content = content || (!lines[i].empty() && lines[i][0] != '#' && lines[i][0] != '%');
  }
}

bool only_comments(const std::string& text) {
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first != std::string::npos && line[first] != '#' && line.compare(first, 3, "---") != 0) return false;
  }
  return true;
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

/// A YAML parser's complaint in the words of the user: the habit behind the text at its place (a tab, an
/// unquoted `*`, a missing space after a colon, a bracket that is not closed), and what to write instead.
/// @param lines    of the document
/// @param at       place of the complaint; line 0: unknown
/// @param message  of the parser, by which the complaint is told from others; it is not shown
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

}  // namespace

const Node* Node::find(std::string_view wanted) const {
  for (const auto& [key, value] : entries)
    if (key.name == wanted) return &value;
  return nullptr;
}

Node* Node::find(std::string_view wanted) {
  return const_cast<Node*>(static_cast<const Node*>(this)->find(wanted));
}

Node scalar_node(const std::string& text) { return {Node::Type::scalar, {}, text, false, {}, {}}; }

Node mapping_node(std::vector<std::pair<std::string, Node>> entries) {
  Node node{Node::Type::mapping, {}, {}, false, {}, {}};
  for (auto& [key, value] : entries) node.entries.push_back({{key, {}}, std::move(value)});
  return node;
}

std::string described(const Node& node) {
  switch (node.type) {
    case Node::Type::null:
      return "nothing";
    case Node::Type::scalar:
      return "'" + node.text + "'";
    case Node::Type::sequence:
      return "a list of " + std::to_string(node.items.size());
    case Node::Type::mapping:
      return "a mapping";
  }
  return {};
}

Node parse_yaml(const std::string& text, const std::string& file) {
  TreeBuilder builder(text, file);
  refuse_odd_lines(builder.lines(), file);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    const bool has_document = parser.HandleNextDocument(builder);
    if (!has_document || builder.empty())
      throw Error({file, 1, 1}, "", only_comments(text) ? "the file is empty" : "the file is not a mapping",
                  "", "a spec begins with 'qerr: 1'");
    // At most one more call: on some malformed input yaml-cpp 0.7 reports documents without end.
    TreeBuilder second(text, file);
    if (parser.HandleNextDocument(second))
      throw Error(second_document(builder.lines(), file), "", "a second YAML document follows",
                  "'---' or text after the end", "keep one document in a file");
  } catch (const YAML::Exception& e) {
    throw Error(syntax_fault(builder.lines(), builder.place(e.mark), e.msg));
  }
  return builder.take();
}

}  // namespace qerr
