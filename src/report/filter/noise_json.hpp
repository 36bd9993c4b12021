#pragma once

#include <nlohmann/json.hpp>

#include "qerr/report/noise_report.hpp"

namespace qerr {

/// The keys that a filter's noise adds to its JSON object.
void add_noise(nlohmann::ordered_json& filter, const FilterNoise&);

/// The key `quantized_sine` of `qerr filter --format json`.
nlohmann::ordered_json sine_error_json(const std::vector<SineErrorRow>&);

}  // namespace qerr
