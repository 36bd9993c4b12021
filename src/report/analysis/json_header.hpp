#pragma once

#include "qerr/report/analysis.hpp"
#include "report/json_header.hpp"

namespace qerr {

/// The members that the JSON of an analysis and of its check begin with: those of every report, and
/// `configurations`.
Json analysis_header(const Analysis&, const char* command);

}  // namespace qerr
