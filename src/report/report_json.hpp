#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "qerr/input/spec.hpp"

/// What the JSON of several commands has in common.
namespace qerr {

/// JSON has no infinity: a figure without bound, or one that is not known, is null.
nlohmann::ordered_json number_or_null(double value);
nlohmann::ordered_json number_or_null(const std::optional<double>& value);

/// The spec that a report is of: its file, the file's hash, and what the command line changed.
nlohmann::ordered_json spec_source(const Spec&);

/// The keys that every report of a spec begins with: `qerr`, `command`, `spec`, `seed`, `robot`.
nlohmann::ordered_json report_header(const Spec&, const char* command, std::uint64_t seed);

}  // namespace qerr
