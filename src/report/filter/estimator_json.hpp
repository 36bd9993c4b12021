#pragma once

#include <nlohmann/json.hpp>

#include "qerr/report/estimator_report.hpp"

namespace qerr {

/// The key `estimators` of `qerr filter --format json`; null where a bound is infinite.
nlohmann::ordered_json estimator_json(const EstimatorReport&);

}  // namespace qerr
