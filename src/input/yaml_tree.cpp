#include "input/yaml_tree.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <map>
#include <sstream>

#include "input/yaml_syntax.hpp"

namespace qerr {

namespace {

constexpr std::size_t most_levels = 64;  // of nesting; the format of a spec has 6

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
    throw Error({place(mark), "", "aliases are not supported", "an alias ('*name')", "write the value out"});
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
      throw Error(
          {place(mark), "", "anchors are not supported", "an anchor ('&name')", "write the value out"});
  }

  void refuse_tag(const YAML::Mark& mark, const std::string& tag) const {
    if (!tag.empty() && tag != "?" && tag != "!")
      throw Error(
          {place(mark), "", "tags are not supported", text_at(lines_, place(mark)), "leave the tag out"});
  }

  /// An escape such as "\e" or, in the path of another system, "\r": no value of a spec has one.
  void refuse_control_characters(const YAML::Mark& mark, const std::string& value) const {
    if (escaped(value, std::string::npos) == value || value.find('\n') != std::string::npos) return;
    throw Error({place(mark), "", "a text must not contain control or invisible characters",
                 "'" + value + "'",
                 "in double quotation marks a backslash begins an escape: use single ones, or '/' in paths"});
  }

  void refuse_typographic_quotes(const YAML::Mark& mark, const std::string& value) const {
    for (const std::string_view quote : {"\u2018", "\u2019", "\u201C", "\u201D", "\u201E", "\u00B4", "`"})
      if (value.starts_with(quote))
        throw Error({place(mark), "", "typographic quotation marks do not quote", "'" + value + "'",
                     "write the plain ' or \""});
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
          throw Error({place(mark), "", "a quotation mark is not closed on its line", "",
                       "end the text with " + std::string(1, quote)});
      }
    }
    if (value.find('\n') != std::string::npos)
      throw Error({place(mark), "", "a value extends over several lines", "", "keep it on one line"});
  }

  void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, Node::Type type) {
    refuse_anchor(mark, anchor);
    refuse_tag(mark, tag);
    if (stack_.size() >= most_levels)
      throw Error({place(mark), "", "values are nested too deeply", "",
                   "at most " + std::to_string(most_levels) + " levels"});
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
      throw Error({node.place, "", "a key must be plain text", described(node), "write 'key: value'"});
    if (node.text == "<<" && !node.quoted)
      throw Error({node.place, "<<", "merge keys are not supported", "'<<'", "write the values out"});
    const auto [first, is_new] = top.keys.emplace(node.text, node.place.line);
    if (!is_new)
      throw Error({node.place, node.text, "duplicate key, already in line " + std::to_string(first->second),
                   "'" + node.text + "'", "keep one of them"});
    top.key = {node.text, node.place};
    top.has_key = true;
  }

  std::string file_;
  std::vector<std::string> lines_;
  std::vector<Open> stack_;
  Node root_;
  bool any_ = false;
};

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
      throw Error({{file, number, static_cast<int>(cr) + 1},
                   "",
                   "a carriage return without a line feed",
                   "",
                   "end lines with LF or CR LF"});
    if (content && lines[i].starts_with('%'))
      throw Error({{file, number, 1},
                   "",
                   "a line must not begin with %",
                   "'" + lines[i].substr(0, 40) + "'",
                   "a comment begins with #"});
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
      throw Error({{file, 1, 1},
                   "",
                   only_comments(text) ? "the file is empty" : "the file is not a mapping",
                   "",
                   "a spec begins with 'qerr: 1'"});
    // At most one more call: on some malformed input yaml-cpp 0.7 reports documents without end.
    TreeBuilder second(text, file);
    if (parser.HandleNextDocument(second))
      throw Error({second_document(builder.lines(), file), "", "a second YAML document follows",
                   "'---' or text after the end", "keep one document in a file"});
  } catch (const YAML::Exception& e) {
    throw Error(syntax_fault(builder.lines(), builder.place(e.mark), e.msg));
  }
  return builder.take();
}

}  // namespace qerr
