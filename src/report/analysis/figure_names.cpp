#include "report/analysis/figure_names.hpp"

#include <cmath>

#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/tables.hpp"

namespace qerr {

std::string FigureName::quantity() const {
  return (filter.empty() ? std::string(signal) : filter) + '.' + std::string(coordinate) + '.' +
         std::string(bound);
}

void for_each_figure(const Analysis& a, const std::function<void(const FigureName&, const Statistic&)>& see) {
  using Bound = ProvenFigure::Bound;
  const std::vector<Coordinate> coordinates = coordinates_and_lengths(a.spec.model);
  const auto see_bound = [&](FigureName& name, std::string_view text, Bound bound, const Statistic& s) {
    name.bound = text;
    name.figure.bound = bound;
    see(name, s);
  };
  for (std::size_t i = 0; i < a.workspace.coordinates.size(); ++i) {
    const CoordinateInfo& c = info(coordinates[i]);
    const CoordinateStatistics& s = a.workspace.coordinates[i];
    FigureName name{"position", "", c.name, std::string(c.unit), {}, {i, -1}, std::string(c.unit)};
    see_bound(name, "worst_case", Bound::worst_case, s.worst_case);
    if (std::isfinite(s.worst_case_rigorous.min))
      see_bound(name, "worst_case_rigorous", Bound::worst_case_rigorous, s.worst_case_rigorous);
    see_bound(name, "sigma", Bound::sigma, s.sigma);
  }
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f)
    for (std::size_t i = 0; i < a.workspace.coordinates.size(); ++i) {
      const Coordinate c = coordinates[i];
      const DerivativeStatistics& s = a.workspace.derivatives[f][i];
      const NamedFilter& filter = a.spec.filters[f];
      FigureName name{"derivative",
                      filter.name,
                      info(c).name,
                      derivative_unit(c, filter.filter),
                      {},
                      {i, static_cast<std::ptrdiff_t>(f)},
                      shown_unit(c, filter.filter)};
      see_bound(name, "worst_case", Bound::worst_case, s.worst_case);
      if (s.sigma) see_bound(name, "sigma", Bound::sigma, *s.sigma);
      if (s.sigma_quantization)
        see_bound(name, "sigma_quantization", Bound::sigma_quantization, *s.sigma_quantization);
      if (s.sigma_in_motion) see_bound(name, "sigma_in_motion", Bound::sigma_in_motion, *s.sigma_in_motion);
    }
}

}  // namespace qerr
