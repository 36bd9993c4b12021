#pragma once

#include <string>

namespace qerr {

/// The byte gate every input document passes: a regular file (or `-`, or a pipe), at most 16 MB, valid UTF-8,
/// no NUL. A leading byte-order mark is dropped.
/// @throws Error (file_system) when it cannot be read, (input) when its bytes are not such text
std::string read_text(const std::string& path);

/// The part of the gate that looks at bytes. @throws Error (input), with line and column of the offending
/// byte
void check_text(const std::string& text, const std::string& file);

}  // namespace qerr
