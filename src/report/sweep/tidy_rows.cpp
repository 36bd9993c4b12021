#include "report/analysis/figure_names.hpp"
#include "report/csv_text.hpp"
#include "report/sweep/rows.hpp"

namespace qerr {

std::string cells_of_variant(const SweepGrid& grid, std::uint64_t variant) {
  std::string cells = std::to_string(variant) + ',';
  for (const std::string& name : grid.names(variant)) cells += csv_cell(name) + ',';
  return cells;
}

SweepRows tidy_rows(const SweepGrid& grid, std::vector<const StatisticKind*> statistics) {
  SweepRows rows{"variant,", {}};
  for (const std::string& key : grid.keys()) rows.header += csv_cell(key) + ',';
  rows.header += analysis_csv_header;
  rows.lines = [&grid, statistics = std::move(statistics)](const SweptVariant& v) {
    const std::string cells = cells_of_variant(grid, v.variant);
    if (!v.check) return cells + "error,,,," + csv_cell(v.fault) + ",,\r\n";
    return analysis_csv_rows(v.check->analysis, cells, statistics);
  };
  return rows;
}

}  // namespace qerr
