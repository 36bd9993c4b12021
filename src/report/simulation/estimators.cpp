
#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "report/analysis/requirements.hpp"
#include "report/analysis/tables.hpp"
#include "report/csv_text.hpp"
#include "report/page/page.hpp"
#include "report/page/plot.hpp"
#include "report/simulation/parts.hpp"
#include "report/text_table.hpp"
#include "simulate/estimators/estimator.hpp"
#include "simulate/settling.hpp"
#include "simulate/velocity_comparison.hpp"

namespace qerr {

std::vector<EstimatedVelocity> estimator_comparison(const Spec& spec, const SimulationOptions& options) {
  std::vector<VelocityFilter> filters;
  for (const NamedFilter& f : spec.filters)
    if (f.filter.derivative == 1 && !f.controller && !has_unknown_unit(f.filter))
      filters.push_back({f.name, f.filter, f.norms, f.joints});
  if (filters.empty() && spec.estimators.empty())
    throw spec_error(spec, "estimators", "the spec has no velocity estimator to compare", "",
                     "add estimators: (qerr list estimators), or filters of derivative 1");
  const Motion& motion = *spec.motion;
  const double numbers = static_cast<double>((filters.size() + spec.estimators.size() + 1) *
                                             spec.model.chain.independent.size() * options.runs) *
                         motion.duration * motion.sample_rate;
  constexpr double most = 5e7;  // numbers that are kept: 400 MB
  if (numbers > most)
    throw spec_error(
        spec, "motion.duration", "the motion has too many samples for a comparison of estimators",
        significant(numbers, 3) + " estimates of at most 5e7", "shorten the motion, or ask for fewer runs");
  std::vector<Filter> designed;
  for (const VelocityFilter& f : filters) designed.push_back(f.filter);
  // Estimators have no settling time of their own: a twentieth of the motion unless the spec says otherwise.
  const double settling =
      motion.settling ? *motion.settling : std::max(settling_time(motion, designed), motion.duration / 20);
  return compare_velocities(spec.model, filters, spec.estimators, motion, spec.effects, settling, options);
}

std::vector<std::string> estimator_warnings(const Spec& spec) {
  std::string timed, unseen;
  const auto add = [](std::string& to, const std::string& name) {
    if (to.find(quoted(name)) == std::string::npos) to += (to.empty() ? "" : ", ") + quoted(name);
  };
  for (const EstimatorDesign& d : spec.estimators)
    if (estimator_kind(d.kind).timed) add(timed, d.name);
  for (const Effect& e : spec.effects)
    if (const EffectKind& kind = effect_kind(e.type); kind.action && acts_on_robot(kind) && has_size(e) &&
                                                      kind.stage != Stage::disc && kind.stage != Stage::line)
      add(unseen, e.type);
  if (timed.empty() || unseen.empty()) return {};
  return {"estimators that time edges (" + timed + ") see the motion and the disc alone: " + unseen +
          " of the spec " + (unseen.find(", ") == std::string::npos ? "is" : "are") +
          " in the rows of the others, and the ranking favours those that time edges"};
}

std::string speed_unit(const SimulationReport& r, const EstimatedVelocity& e) {
  return r.spec.model.chain.independent[e.joint].prismatic() ? "m/s" : "rad/s";
}

namespace {

const std::string& joint_of(const SimulationReport& r, const EstimatedVelocity& e) {
  return r.spec.model.chain.independent[e.joint].name;
}

/// Whether it times edges, beside effects that only estimators of counts see.
bool sees_less(const Spec& spec, const EstimatedVelocity& e) {
  return std::any_of(spec.estimators.begin(), spec.estimators.end(),
                     [&](const EstimatorDesign& d) {
                       return d.name == e.estimator && estimator_kind(d.kind).timed;
                     }) &&
         !estimator_warnings(spec).empty();
}

std::vector<std::string> cells_of(const SimulationReport& r, const EstimatedVelocity& e) {
  const std::string unit = speed_unit(r, e);
  return {escaped(joint_of(r, e), 22) + ": " + escaped(e.estimator, 40),
          e.kind + (sees_less(r.spec, e) ? ", without effects" : ""),
          readable(e.rms, unit),
          e.delay ? readable(*e.delay, "s") : "none",
          readable(e.tracking, unit),
          readable(e.noise, unit),
          readable(e.worst, unit),
          e.worst_case ? readable(*e.worst_case, unit) : "-"};
}

const std::vector<std::string> heads{"joint: estimator", "kind",       "total", "delay",
                                     "by the delay",     "noise left", "worst", "bound"};
constexpr const char* legend =
    "total: rms of the estimate minus the true velocity; delay: by which the true velocity fits the estimate "
    "best; by the delay: rms of what it alone makes; noise left: rms about the late velocity; worst: largest "
    "error; bound: proven, of what the counts add to that of the delay";

}  // namespace

std::string estimator_table(const SimulationReport& r, const Style& style) {
  TableRows rows{heads};
  for (const EstimatedVelocity& e : r.estimators) rows.push_back(cells_of(r, e));
  return heading("Velocity estimators along the motion, of each joint the least error first", style) +
         fitted_table(rows, style.width) + wrapped(legend, style.width, "  ");
}

std::string estimator_figures(const SimulationReport& r) {
  std::string out;
  TableRows rows;
  for (std::size_t i = 0; i < r.estimators.size(); ++i) {
    const EstimatedVelocity& first = r.estimators[i];
    rows.push_back(cells_of(r, first));
    if (i > 0 && r.estimators[i - 1].joint == first.joint) continue;
    page::Plot plot{page::isolated_runs("Error against speed of " + joint_of(r, first)),
                    "Rms error of each estimate in classes of the true speed.",
                    {"speed", speed_unit(r, first), true},
                    {"error, rms", speed_unit(r, first), true},
                    {}};
    for (std::size_t k = i; k < r.estimators.size() && r.estimators[k].joint == first.joint; ++k) {
      page::Series line{page::isolated_runs(r.estimators[k].estimator), {}};
      for (const ErrorAtSpeed& at : r.estimators[k].by_speed)
        if (at.speed > 0 && at.rms > 0) line.points.emplace_back(at.speed, at.rms);
      if (line.points.size() > 1) plot.series.push_back(line);
    }
    if (!plot.series.empty()) out += figure(plot);
  }
  return page::side_by_side(out) + page::table(heads, rows) + page::paragraph(legend);
}

std::string estimator_csv(const SimulationReport& r) {
  std::string out = "estimator,kind,coordinate,unit,rms,noise,tracking,delay,worst,worst_case\r\n";
  for (const EstimatedVelocity& e : r.estimators) {
    out += csv_cell(e.estimator) + ',' + e.kind + ',' + csv_cell(joint_of(r, e)) + ',' + speed_unit(r, e);
    for (const auto& value : {std::optional(e.rms), std::optional(e.noise), std::optional(e.tracking),
                              e.delay, std::optional(e.worst), e.worst_case})
      out += ',' + csv_number(value);
    out += "\r\n";
  }
  return out;
}

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
  TableRows rows{{"cut-off", "encoder error", "tracking error", "total", ""}};
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
