#pragma once

#include <string>

#include "input/yaml_tree.hpp"

namespace qerr {

/// A value in one line of YAML, mappings in braces and lists in brackets.
std::string flow(const Node&);

/// A scalar in such a line: plain if possible, in quotation marks if necessary or if it was quoted.
std::string flow_scalar(const std::string& text, bool quoted);

/// A key in such a line, with its colon.
std::string flow_key(const std::string& name);

/// A key that is written so, with what divides it from its value: `KEY: `. YAML takes more than 1024
/// characters for a key only behind a question mark, in lines with the value on the next one.
/// @param indent  of the line
std::string block_key(const std::string& written, const std::string& indent);

/// A comment of one or more lines, each with its `# `, indented. @returns "" for no comment
std::string commented(const std::string& comment, const std::string& indent);

/// Whether two values are equal, apart from places and comments.
bool same_value(const Node&, const Node&);

/// Edits a YAML text so that it has the value `wanted`; comments, order and layout of unchanged values are
/// kept. Scalars and values in brackets or braces can be replaced, keys added to any mapping, items appended
/// to any list.
/// @param text  one document, valid for parse_yaml
/// @param replaced  dotted paths of entries whose comments go where their values change
/// @throws Error (input), with the place, if the layout of the text does not allow the change
std::string rewritten(const std::string& text, const Node& wanted, const std::string& file,
                      const std::vector<std::string>& replaced = {});

}  // namespace qerr
