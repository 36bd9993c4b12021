#include "report/analysis/figure_names.hpp"

#include <cmath>

#include "report/analysis/control.hpp"
#include "report/analysis/count_rates.hpp"
#include "report/analysis/tables.hpp"

namespace qerr {

namespace {

FigureName name_of(const Spec& spec, const Signal& s, const Figure& f) {
  const NamedFilter* filter = f.filter < 0 ? nullptr : &spec.filters[static_cast<std::size_t>(f.filter)];
  if (filter && filter->controller)
    return {f,
            "torque",
            "",
            s.name,
            derivative_unit(s.unit, filter->filter),
            name_of(f.bound),
            shown_unit(s.unit, filter->filter)};
  if (is_closed(s))  // closed_torque.a1
    return {f, s.kind->group, "", s.name.substr(s.kind->group.size() + 1), s.unit, name_of(f.bound), s.unit};
  return {f,
          filter ? "derivative" : "position",
          filter ? filter->name : "",
          s.name,
          filter ? derivative_unit(s.unit, filter->filter) : s.unit,
          name_of(f.bound),
          filter ? shown_unit(s.unit, filter->filter) : s.unit};
}

}  // namespace

std::string FigureName::quantity() const {
  return (filter.empty() ? std::string(signal) : filter) + '.' + coordinate + '.' + std::string(bound);
}

FigureName name_of(const Spec& spec, const Figure& f) {
  return name_of(spec, all_signals(spec.model)[f.signal], f);
}

bool is_passed(const Spec& spec, std::ptrdiff_t filter, const Signal& s) {
  return filter < 0 || is_filtered(spec.filters[static_cast<std::size_t>(filter)], s);
}

std::vector<FigureName> all_figures(const Spec& spec) {
  const std::vector<Signal> signals = all_signals(spec.model);
  std::vector<FigureName> figures;
  const auto add = [&](std::ptrdiff_t filter) {
    for (std::size_t s = 0; s < signals.size(); ++s)
      if (is_passed(spec, filter, signals[s]))
        for (const Bound bound : bounds_of(filter >= 0))
          if (bound != Bound::worst_case_rigorous || !is_closed(signals[s]))  // a loop is linear as it is
            figures.push_back(name_of(spec, signals[s], {s, filter, bound}));
  };
  for (std::ptrdiff_t f = -1; f < std::ssize(spec.filters); ++f) add(f);
  return figures;
}

void for_each_figure(const Analysis& a, const std::function<void(const FigureName&, const Statistic&)>& see) {
  for (const FigureName& name : all_figures(a.spec)) {
    const Statistic* const s = statistic_of(a.workspace, name.figure);
    if (s && (std::isfinite(s->min) || name.figure.bound != Bound::worst_case_rigorous)) see(name, *s);
  }
}

std::vector<SingleFigure> single_figures(const Analysis& a) {
  std::vector<SingleFigure> all;
  if (a.control) all = control_rows(a.spec, *a.control);
  EncoderSpeeds speeds;
  for (std::size_t i = 0; i < a.spec.encoder_figures.size(); ++i) {
    const std::optional<CountLimit> limit = count_limit(a.spec, i);
    if (!limit) continue;
    if (speeds.empty()) speeds = encoder_speeds(a.spec);
    const std::string encoder = "encoder." + a.spec.model.chain.independent[i].name;
    if (speeds[i]) all.push_back({encoder + ".count_rate", "1/s", "max", count_rate(a.spec, i, *speeds[i])});
    all.push_back({encoder + ".max_count_rate", "1/s", "max", limit->rate});
  }
  return all;
}

}  // namespace qerr
