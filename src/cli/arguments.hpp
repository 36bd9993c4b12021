#pragma once

#include <string>
#include <vector>

#include "cli/command.hpp"

namespace qerr::cli {

/// What the words behind the name of a command say, by its rows.
///
/// Written as with GNU programs: `--runs 3`, `--runs=3`, `-o FILE`, `-oFILE`, `-qo FILE`; `--` ends the
/// options.
/// @throws Error (usage) for words that do not fit the rows
Values parse_arguments(const Command&, const std::vector<std::string>& words);

/// `qerr analyze [OPTION...] SPEC`
std::string usage_line(const Command&);

}  // namespace qerr::cli
