#include <cmath>

#include "qerr/kinematics/coordinates.hpp"
#include "report/csv_text.hpp"
#include "report/formats.hpp"

namespace qerr {

namespace {

void add_statistic(std::string& out, const std::string& prefix, const Statistic& s) {
  for (const StatisticKind& kind : statistic_kinds())
    out += prefix + ',' + std::string(kind.name) + ',' + csv_number(s.*kind.value) + "\r\n";
}

}  // namespace

std::string to_csv(const Analysis& a, const Style&) {
  const std::vector<Coordinate> coordinates = coordinates_and_lengths(a.spec.model);
  std::string out = "signal,filter,coordinate,unit,bound,statistic,value\r\n";
  for (std::size_t i = 0; i < a.workspace.coordinates.size(); ++i) {
    const CoordinateInfo& c = info(coordinates[i]);
    const std::string prefix = "position,," + std::string(c.name) + ',' + std::string(c.unit) + ',';
    add_statistic(out, prefix + "worst_case", a.workspace.coordinates[i].worst_case);
    if (std::isfinite(a.workspace.coordinates[i].worst_case_rigorous.min))
      add_statistic(out, prefix + "worst_case_rigorous", a.workspace.coordinates[i].worst_case_rigorous);
    add_statistic(out, prefix + "sigma", a.workspace.coordinates[i].sigma);
  }
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f)
    for (std::size_t i = 0; i < a.workspace.coordinates.size(); ++i) {
      const Coordinate c = coordinates[i];
      const std::string prefix = "derivative," + csv_cell(a.spec.filters[f].name) + ',' +
                                 std::string(info(c).name) + ',' +
                                 derivative_unit(c, a.spec.filters[f].filter.derivative) + ',';
      add_statistic(out, prefix + "worst_case", a.workspace.derivatives[f][i].worst_case);
      if (const auto& sigma = a.workspace.derivatives[f][i].sigma)
        add_statistic(out, prefix + "sigma", *sigma);
      if (const auto& moving = a.workspace.derivatives[f][i].sigma_in_motion)
        add_statistic(out, prefix + "sigma_in_motion", *moving);
    }
  const std::vector<double> budget = encoder_budget(a);
  for (std::size_t i = 0; i < budget.size(); ++i)
    out += "budget,," + csv_cell(a.spec.model.chain.independent[i].name) + ",,share,mean," +
           csv_number(budget[i]) + "\r\n";
  return out;
}

}  // namespace qerr
