#pragma once

#include <string>

#include "input/log_table.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// A mapping of the columns of a log whose names say little: guessed by names (of joints, or their numbers;
/// words for quantities), units and first values. The mapping of the spec and columns that are called as
/// signals are kept. It is a proposal: a user is asked, and can paste it.
/// @pre no row of the log has been read
/// @returns no columns if it finds no measured joint
LogReading proposed_mapping(const LogTable&, const Spec&);

/// A mapping as options of the command line and, behind them, as a section `log:` of a spec: lines to paste.
std::string mapping_text(const LogReading&);

}  // namespace qerr
