#pragma once

#include <vector>

#include "cli/shared.hpp"
#include "report/sweep/rows.hpp"
#include "report/sweep/run_sweep.hpp"

/// What sweep and merge share: which rows the CSV of a sweep has.
namespace qerr::cli {

/// `--statistics` and `--wide`.
std::vector<Option> sweep_row_options();

/// In the order of the reports, whatever that of the option.
std::vector<const StatisticKind*> chosen_statistics(const Values&);

/// The rows that the options ask for; sets what the job needs for them.
SweepRows chosen_rows(SweepJob&, const Values&);

}  // namespace qerr::cli
