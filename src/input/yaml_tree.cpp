#include "input/yaml_tree.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <charconv>
#include <set>
#include <sstream>

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

  /// The text at a place, for messages about syntax.
  std::string text_at(const YAML::Mark& mark) const {
    const auto line = static_cast<std::size_t>(mark.line), column = static_cast<std::size_t>(mark.column);
    if (mark.is_null() || line >= lines_.size() || column >= lines_[line].size())
      return "the end of the line";
    return "'" + lines_[line].substr(column, 40) + "'";
  }

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
    std::set<std::string> keys = {};
  };

  void refuse_anchor(const YAML::Mark& mark, YAML::anchor_t anchor) const {
    if (anchor != 0)
      throw Error(
          {place(mark), "", "anchors are not supported", "an anchor ('&name')", "write the value out"});
  }

  void refuse_tag(const YAML::Mark& mark, const std::string& tag) const {
    if (!tag.empty() && tag != "?" && tag != "!")
      throw Error({place(mark), "", "tags are not supported", "'" + tag + "'", "leave the tag out"});
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
    if (!top.keys.insert(node.text).second)
      throw Error({node.place, node.text, "duplicate key", "'" + node.text + "'", "keep one of them"});
    top.key = {node.text, node.place};
    top.has_key = true;
  }

  std::string file_;
  std::vector<std::string> lines_;
  std::vector<Open> stack_;
  Node root_;
  bool any_ = false;
};

bool only_comments(const std::string& text) {
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first != std::string::npos && line[first] != '#' && line.compare(first, 3, "---") != 0) return false;
  }
  return true;
}

/// The child of `node` that the first key of the path names, and the remaining path.
std::pair<Node*, std::string> step(Node& node, const std::string& path, const Fault& fault) {
  if (node.type == Node::Type::sequence) {
    const std::size_t dot = std::min(path.find('.'), path.size());
    std::size_t index = 0;
    const auto [end, failure] = std::from_chars(path.data(), path.data() + dot, index);
    if (failure != std::errc{} || end != path.data() + dot || index >= node.items.size()) throw Error(fault);
    return {&node.items[index], dot == path.size() ? "" : path.substr(dot + 1)};
  }
  if (node.type == Node::Type::null) node.type = Node::Type::mapping;
  if (node.type != Node::Type::mapping) throw Error(fault);
  Node* child = nullptr;
  std::size_t longest = 0;
  for (auto& [key, value] : node.entries) {
    const bool matches = path == key.name || path.starts_with(key.name + ".");
    if (matches && key.name.size() >= longest) {
      child = &value;
      longest = key.name.size();
    }
  }
  if (!child) {
    longest = std::min(path.find('.'), path.size());
    const Node::Key key{path.substr(0, longest), fault.place};
    if (key.name.empty()) throw Error(fault);
    node.entries.push_back({key, Node{Node::Type::null, fault.place, {}, false, {}, {}}});
    child = &node.entries.back().value;
  }
  return {child, longest == path.size() ? "" : path.substr(longest + 1)};
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
      throw Error({second.place(YAML::Mark()), "", "a second YAML document follows",
                   "'---' or text after the end", "keep one document in a file"});
  } catch (const YAML::Exception& e) {
    throw Error({builder.place(e.mark), "", "not valid YAML: " + e.msg, "",
                 "check indentation, brackets and quotes"});
  }
  return builder.take();
}

void apply_override(Node& root, const std::string& path, const std::string& value,
                    const std::string& origin) {
  const Fault fault{{origin, 0, 0},
                    path,
                    "no such key in the spec",
                    "'" + path + "'",
                    "name a key by its path, such as filters.velocity.lowpass.cutoff, or a list's item by "
                    "its number from 0"};
  Node replacement = parse_yaml(value.empty() ? "''" : value, origin);
  Node* node = &root;
  std::string remaining = path;
  do {
    std::tie(node, remaining) = step(*node, remaining, fault);
  } while (!remaining.empty());
  *node = std::move(replacement);
}

}  // namespace qerr
