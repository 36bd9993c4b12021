#pragma once

#include <vector>

#include "cli/shared.hpp"
#include "report/sweep/rows.hpp"
#include "report/sweep/run_record.hpp"
#include "report/sweep/run_sweep.hpp"

/// What sweep and merge share: which rows the CSV of a sweep has.
namespace qerr::cli {

/// `--statistics` and `--wide`.
std::vector<Option> sweep_row_options();

/// In the order of the reports, whatever that of the option.
std::vector<const StatisticKind*> chosen_statistics(const Values&);

/// The rows that the options ask for; sets what the job needs for them.
SweepRows chosen_rows(SweepJob&, const Values&);

/// What the rows of the job depend on.
RunRecord record_of(const SweepJob&, const Values&);

/// A line to standard error, with --quiet, too.
void say(const std::string& line);
/// `3 of 175 variants`.
std::string of_variants(std::uint64_t number, const SweepCounts&);
/// How many variants were not computed, if there are any.
void say_failed(const SweepCounts&);

}  // namespace qerr::cli
