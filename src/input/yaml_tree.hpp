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

/// A value in one line of YAML, mappings in braces and lists in brackets.
std::string flow(const Node&);

/// A scalar in such a line: plain if possible, in quotation marks if necessary or if it was quoted.
std::string flow_scalar(const std::string& text, bool quoted);

/// A key that is written so, with what divides it from its value: `KEY: `. YAML takes more than 1024
/// characters for a key only behind a question mark, in lines with the value on the next one.
/// @param indent  of the line
std::string block_key(const std::string& written, const std::string& indent);

/// A comment of one or more lines, each with its `# `, indented. @returns "" for no comment
std::string commented(const std::string& comment, const std::string& indent);

/// Whether two values mean the same, as 1 kHz and 1000 do, apart from places and comments.
bool same_meaning(const Node&, const Node&);

/// Edits a YAML text so that it has the value `wanted`; comments, order and layout of unchanged values are
/// kept. Scalars and values in brackets or braces can be replaced, keys added to any mapping, items appended
/// to any list.
/// @param text  one document, valid for parse_yaml
/// @param replaced  dotted paths of entries whose comments go where their values change
/// @throws Error (input), with the place, if the layout of the text does not allow the change
std::string rewritten(const std::string& text, const Node& wanted, const std::string& file,
                      const std::vector<std::string>& replaced = {});

}  // namespace qerr
