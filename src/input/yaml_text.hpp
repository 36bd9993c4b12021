#pragma once

#include <string>

#include "input/yaml_tree.hpp"

namespace qerr {

/// A value in one line of YAML, mappings in braces and lists in brackets.
std::string flow(const Node&);

/// A scalar in such a line: plain where it can be, in quotes where it must be or was.
std::string flow_scalar(const std::string& text, bool quoted);

/// A comment of one or more lines, each with its `# `, indented. @returns "" for no comment
std::string commented(const std::string& comment, const std::string& indent);

/// Whether two values say the same; places and comments do not count.
bool says_the_same(const Node&, const Node&);

/// Changes a YAML text as little as possible so that it says `wanted`: comments, order and layout of all that
/// stays are kept. Scalars and values in brackets or braces can be replaced, keys added to any mapping, items
/// added at the end of any list.
/// @param text  one document, as parse_yaml takes it
/// @throws Error (input), with the place, where the text is laid out such that the change cannot be made
std::string rewritten(const std::string& text, const Node& wanted, const std::string& file);

}  // namespace qerr
