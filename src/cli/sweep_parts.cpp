#include "cli/sweep_parts.hpp"

#include <algorithm>

#include "report/analysis/figure_names.hpp"

namespace qerr::cli {

namespace {

std::vector<std::string> statistic_names() {
  std::vector<std::string> names;
  for (const StatisticKind& kind : statistic_kinds()) names.emplace_back(kind.name);
  return names;
}

}  // namespace

std::vector<const StatisticKind*> chosen_statistics(const Values& v) {
  if (!v.given("statistics")) return all_statistics();
  std::vector<const StatisticKind*> chosen;
  for (const StatisticKind* kind : all_statistics()) {
    const auto& names = v.texts("statistics");
    if (std::find(names.begin(), names.end(), kind->name) != names.end()) chosen.push_back(kind);
  }
  return chosen;
}

std::vector<Option> sweep_row_options() {
  return {{.name = "--statistics",
           .value = "NAME,...",
           .kind = OptionKind::list,
           .meaning = "write these statistics only, e.g. max,p99 (qerr list statistics)",
           .choices = statistic_names,
           .choice = "statistic"},
          {.name = "--wide",
           .kind = OptionKind::flag,
           .meaning = "CSV with one row a variant: figures, filters, requirements"}};
}

SweepRows chosen_rows(SweepJob& job, const Values& v) {
  const SweepRows rows = v.given("wide") ? wide_rows(job.grid, job.variants, job.statistics)
                                         : tidy_rows(job.grid, job.statistics);
  job.text = rows.lines;
  job.judged = v.given("wide");
  return rows;
}

}  // namespace qerr::cli
