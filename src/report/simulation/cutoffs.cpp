#include "report/simulation/cutoffs.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "qerr/report/analysis.hpp"
#include "report/analysis/tables.hpp"
#include "report/text_table.hpp"

namespace qerr {

std::vector<double> cutoffs_between(double from, double to, std::size_t count) {
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) {
    const double way = static_cast<double>(i) / static_cast<double>(count - 1);
    values.push_back(rounded_to(from * std::pow(to / from, way), 4));
  }
  values.front() = from;
  values.back() = to;
  return values;
}

std::vector<CutoffChoice> cutoff_choices(const SimulationReport& r) {
  std::vector<CutoffChoice> choices;
  for (std::size_t i = 0; i < r.cutoffs->values.size(); ++i) {
    CutoffChoice choice{r.cutoffs->values[i], 0, 0, 0};
    const std::vector<SimulatedSignal>& signals = r.simulation.results[i + 1];
    for (std::size_t c = 0; c < signals.size(); ++c) {
      if (!is_position(r.spec.model.coordinates[c])) continue;
      const SimulatedSignal& s = signals[c];
      choice.noise = std::hypot(choice.noise, s.sigma_simulated, s.mean_simulated);
      choice.tracking = std::hypot(choice.tracking, s.tracking_rms);
      choice.total = std::hypot(choice.total, s.total_rms);
    }
    choices.push_back(choice);
  }
  return choices;
}

std::size_t best_of(const std::vector<CutoffChoice>& choices) {
  const auto best =
      std::min_element(choices.begin(), choices.end(),
                       [](const CutoffChoice& a, const CutoffChoice& b) { return a.total < b.total; });
  return static_cast<std::size_t>(best - choices.begin());
}

std::string cutoff_unit(const SimulationReport& r) { return shown_unit("m", r.spec.filters[0].filter); }

std::string cutoff_table(const SimulationReport& r, const Style& style) {
  const std::vector<CutoffChoice> choices = cutoff_choices(r);
  const std::size_t best = best_of(choices);
  const std::string unit = cutoff_unit(r);
  std::vector<std::vector<std::string>> rows{{"cut-off", "encoder error", "tracking error", "total", ""}};
  for (std::size_t i = 0; i < choices.size(); ++i) {
    const CutoffChoice& c = choices[i];
    rows.push_back({readable(c.cutoff, "Hz"), readable(c.noise, unit), readable(c.tracking, unit),
                    readable(c.total, unit), i == best ? "<- least" : ""});
  }
  std::string coordinates;
  for (const Coordinate c : r.spec.model.coordinates)
    if (is_position(c)) coordinates += ' ' + std::string(info(c).name);
  const bool at_end = best == 0 || best + 1 == choices.size();
  const std::string remark =
      at_end
          ? "the least is at an end of the range: widen it"
          : "total: the estimate minus the true derivative; tracking error: what the filter does to the true "
            "signal";
  return heading("Filter '" + escaped(r.cutoffs->filter, 40) + "': root mean square errors of" + coordinates +
                     " together, along the motion",
                 style) +
         fitted_table(rows, style.width) + wrapped(remark, style.width, "  ");
}

}  // namespace qerr
