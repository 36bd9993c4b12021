#pragma once

#include <string>
#include <vector>

#include "qerr/core/error.hpp"

namespace qerr {

/// A YAML parser's complaint in the words of the user: the habit behind the text at its place (a tab, an
/// unquoted `*`, a missing space after a colon, a bracket that is not closed), and what to write instead.
/// @param lines    of the document
/// @param at       place of the complaint; line 0: unknown
/// @param message  of the parser, by which the complaint is told from others; it is not shown
Fault syntax_fault(const std::vector<std::string>& lines, const Place& at, const std::string& message);

/// What is written at a place, for messages: up to 40 bytes of the line, in quotation marks.
std::string text_at(const std::vector<std::string>& lines, const Place&);

}  // namespace qerr
