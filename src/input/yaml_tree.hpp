#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "qerr/core/error.hpp"

namespace qerr {

/// A value of strict YAML: one document, no aliases, tags or merge keys, unique keys, every place known.
struct Node {
  enum class Type { null, scalar, sequence, mapping };

  /// A key with its own place, at which messages about the key point.
  struct Key {
    std::string name;
    Place place;
  };

  struct Entry;  // contains a Node, hence defined below it

  Type type = Type::null;
  Place place;
  std::string text;     ///< of a scalar, as written
  bool quoted = false;  ///< "12" is text, 12 is a number
  std::vector<Node> items;
  std::vector<Entry> entries;
  std::string comment = {};  ///< written above the value by `rewritten`; empty in a tree that was read

  const Node* find(std::string_view key) const;
  Node* find(std::string_view key);
};

struct Node::Entry {
  Key key;
  Node value;
};

/// Values that are built rather than read: they have no place.
Node scalar_node(const std::string& text);
Node mapping_node(std::vector<std::pair<std::string, Node>> entries);

/// A value as messages name it after "found": `'12 mm'`, `a list of 3`, `a mapping`, `nothing`.
std::string described(const Node&);

/// Parses one YAML document with yaml-cpp's events.
/// @throws Error (input) with file, line and column
Node parse_yaml(const std::string& text, const std::string& file);

/// A YAML parser's complaint in the words of the user: the habit behind the text at its place (a tab, an
/// unquoted `*`, a missing space after a colon, a bracket that is not closed), and what to write instead.
/// @param lines    of the document
/// @param at       place of the complaint; line 0: unknown
/// @param message  of the parser, by which the complaint is told from others; it is not shown
Fault syntax_fault(const std::vector<std::string>& lines, const Place& at, const std::string& message);

/// What is written at a place, for messages: up to 40 bytes of the line, in quotation marks.
std::string text_at(const std::vector<std::string>& lines, const Place&);

}  // namespace qerr
