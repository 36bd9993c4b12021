#pragma once

#include <cstddef>
#include <string>

#include "qerr/core/error.hpp"

namespace qerr {

/// The text of an input document: a regular file, a pipe, or `-` for standard input, with at most 16 MB of
/// valid UTF-8 without NUL. A leading byte-order mark is removed.
/// @throws Error (file_system) if it cannot be read, (input) if its bytes are not such text
std::string read_text(const std::string& path);

/// Checks size and encoding of a text.
/// @throws Error (input), with line and column of the first invalid byte
void check_text(const std::string& text, const std::string& file);

/// The place of a byte that follows well-formed UTF-8; a column is a code point.
/// @pre byte <= text.size()
Place place_of_byte(const std::string& text, std::size_t byte, const std::string& file);

}  // namespace qerr
