#include "report/analysis/figure_names.hpp"
#include "report/csv_text.hpp"
#include "report/sweep/rows.hpp"

namespace qerr {

std::string cells_of_variant(const SweepGrid& grid, std::uint64_t variant) {
  std::string cells = std::to_string(variant) + ',';
  const std::vector<std::size_t> steps = grid.steps(variant);
  const std::vector<std::string> names = grid.names(variant);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const SweepColumn& column = grid.columns()[k];
    cells +=
        (column.values.empty() ? csv_cell(names[k]) : csv_number(column.values[steps[column.axis]])) + ',';
  }
  return cells;
}

std::string header_of_variants(const SweepGrid& grid) {
  std::string header = "variant,";
  for (const SweepColumn& column : grid.columns()) header += csv_cell(column.header()) + ',';
  return header;
}

SweepRows tidy_rows(const SweepGrid& grid, std::vector<const StatisticKind*> statistics) {
  SweepRows rows{header_of_variants(grid) + std::string(analysis_csv_header), {}};
  rows.lines = [&grid, statistics = std::move(statistics)](const SweptVariant& v) {
    const std::string cells = cells_of_variant(grid, v.variant);
    if (!v.check) return cells + "error,,,," + csv_cell(v.fault) + ",,\r\n";
    return analysis_csv_rows(v.check->analysis, cells, statistics);
  };
  return rows;
}

}  // namespace qerr
