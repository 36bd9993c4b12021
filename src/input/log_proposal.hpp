#pragma once

#include <string>
#include <vector>

#include "input/log_table.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// A mapping that a user is asked about, and can paste.
struct MappingProposal {
  LogReading reading;
  std::vector<std::string> left_out;  ///< columns that look like signals, each with what is not known of it
};

/// A mapping of the columns of a log whose names say little: guessed by names (of joints, or their numbers;
/// words for quantities), units and first values. The mapping of the spec and columns that are called as
/// signals are kept.
/// @pre no row of the log has been read
/// @returns no columns if it finds no measured joint
MappingProposal proposed_mapping(const LogTable&, const Spec&);

/// The header of a column that may be the time of a log without one: it rises in equal steps, and its name
/// says nothing else; "" if there is none.
std::string likely_time(const LogTable&, const Spec&);

/// A mapping as options of the command line and, behind them, as a section `log:` of a spec: lines to paste.
std::string mapping_text(const MappingProposal&);

}  // namespace qerr
