#pragma once

#include <string>

#include "qerr/report/filter_report.hpp"

namespace qerr {

std::string filter_table(const FilterReport&);

/// `filter,quantity,unit,value`, everything that was asked of the filters themselves.
std::string filter_csv(const FilterReport&);

}  // namespace qerr
