#pragma once

#include <string>

namespace qerr::fuzz {

/// A table of comma-separated values with one change: of a cell, a column, a row or the header.
/// @returns empty if the text has less than a header and one row
std::string changed_table(const std::string& text, unsigned seed);

}  // namespace qerr::fuzz
