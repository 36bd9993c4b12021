#include "report/analysis/figure_names.hpp"

#include <cmath>

#include "qerr/kinematics/coordinates.hpp"

namespace qerr {

std::string FigureName::quantity() const {
  return (filter.empty() ? std::string(signal) : filter) + '.' + std::string(coordinate) + '.' +
         std::string(bound);
}

void for_each_figure(const Analysis& a, const std::function<void(const FigureName&, const Statistic&)>& see) {
  const std::vector<Coordinate> coordinates = coordinates_and_lengths(a.spec.model);
  for (std::size_t i = 0; i < a.workspace.coordinates.size(); ++i) {
    const CoordinateInfo& c = info(coordinates[i]);
    const CoordinateStatistics& s = a.workspace.coordinates[i];
    FigureName name{"position", "", c.name, std::string(c.unit), "worst_case"};
    see(name, s.worst_case);
    name.bound = "worst_case_rigorous";
    if (std::isfinite(s.worst_case_rigorous.min)) see(name, s.worst_case_rigorous);
    name.bound = "sigma";
    see(name, s.sigma);
  }
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f)
    for (std::size_t i = 0; i < a.workspace.coordinates.size(); ++i) {
      const Coordinate c = coordinates[i];
      const DerivativeStatistics& s = a.workspace.derivatives[f][i];
      const NamedFilter& filter = a.spec.filters[f];
      FigureName name{"derivative", filter.name, info(c).name, derivative_unit(c, filter.filter.derivative),
                      "worst_case"};
      see(name, s.worst_case);
      name.bound = "sigma";
      if (s.sigma) see(name, *s.sigma);
      name.bound = "sigma_in_motion";
      if (s.sigma_in_motion) see(name, *s.sigma_in_motion);
    }
}

}  // namespace qerr
