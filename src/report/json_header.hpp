#pragma once

#include <cstdint>

#include "qerr/input/spec.hpp"
#include "report/json_value.hpp"

/// What the JSON of several reports begins with.
namespace qerr {

/// The spec of a report: its file, the file's hash, and the values that the command line replaced.
Json spec_source(const Spec&);

/// The members `qerr`, `command`, `spec`, `seed`, `robot`.
Json report_header(const Spec&, const char* command, std::uint64_t seed);

}  // namespace qerr
