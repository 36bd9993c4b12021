#pragma once

#include <string>

#include "qerr/report/filter_report.hpp"

namespace qerr {

/// Parts of the table of `qerr filter`.

/// The accuracy of IPQN behind every filter, and the noise in motion; "" if the report has neither.
std::string noise_table(const FilterReport&, std::size_t width);

std::string estimator_table(const EstimatorReport&, std::size_t width);

}  // namespace qerr
