#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "qerr/core/error.hpp"

namespace qerr {

/// A strict YAML value: one document, no aliases, tags or merge keys, unique keys, every place known.
struct Node {
  enum class Type { null, scalar, sequence, mapping };

  /// A key with its own place, so that a message about a key points at the key.
  struct Key {
    std::string name;
    Place place;
  };

  Type type = Type::null;
  Place place;
  std::string text;     ///< of a scalar, as written
  bool quoted = false;  ///< "12" is text, 12 is a number
  std::vector<Node> items;
  std::vector<std::pair<Key, Node>> entries;
  std::string comment = {};  ///< to be written above it; what is read has none

  const Node* find(std::string_view key) const;
};

/// What a value is, for "found ...": `'12 mm'`, `a list of 3`, `a mapping`, `nothing`.
std::string described(const Node&);

/// Parses one YAML document with yaml-cpp's events.
/// @throws Error (input) with file, line and column
Node parse_yaml(const std::string& text, const std::string& file);

/// Replaces or adds the value at a dotted path (`encoders.elbow.bits`, `requirements.0.at_most`); where keys
/// contain dots the longest matching key is taken.
/// @param value  YAML text of the new value
/// @throws Error (input) when the path leads through a scalar or past the end of a list, or the value is not
/// YAML
void apply_override(Node& root, const std::string& path, const std::string& value, const std::string& origin);

}  // namespace qerr
