#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace qerr {

/// JSON whose objects keep the order in which their members were added. A number that is not finite is null.
using Json = nlohmann::ordered_json;

/// The value that a text holds (RFC 8259), with at most 64 levels.
/// @param file  that has the text, for messages
/// @throws Error (input) with line and column where it is no JSON
Json parse_json(const std::string& text, const std::string& file);

/// The document: indented by two blanks a level, with a line break at its end. Doubles are written with as many
/// digits as read back as the same double; bytes that are not UTF-8 are replaced by U+FFFD.
std::string document(const Json&);
/// The document on one line, without the break.
std::string line(const Json&);

}  // namespace qerr
