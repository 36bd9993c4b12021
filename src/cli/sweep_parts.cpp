#include "cli/sweep_parts.hpp"

#include <algorithm>
#include <cstdio>

#include "core/text.hpp"
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
  job.judged = job.judged || v.given("wide");
  return rows;
}

RunRecord record_of(const SweepJob& job, const Values& v) {
  std::vector<std::pair<std::string, std::string>> options;
  for (const char* name : {"set", "seed", "statistics", "wide"}) {
    std::string value;
    for (const std::string& text : v.texts(name)) value += text + '\n';
    if (v.given(name)) options.emplace_back("--" + std::string(name), value);
  }
  return {job.variants, job.grid, options};
}

void say(const std::string& line) {
  clear_progress();
  std::fputs(("qerr: " + line + '\n').c_str(), stderr);
}

std::string of_variants(std::uint64_t number, const SweepCounts& counts) {
  return std::to_string(number) + " of " + counted(counts.variants, "variant");
}

void say_failed(const SweepCounts& counts) {
  if (counts.failed > 0)
    say(of_variants(counts.failed, counts) + " cannot be computed or judged: the rows say why");
}

}  // namespace qerr::cli
