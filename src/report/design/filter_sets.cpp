#include <algorithm>
#include <cmath>

#include "control/loop.hpp"
#include "control/loop_response.hpp"
#include "core/text.hpp"
#include "design/filter_choice.hpp"
#include "input/read_sections.hpp"
#include "qerr/filter/norms.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figures.hpp"
#include "report/design/design_solver.hpp"

namespace qerr {

namespace {

constexpr std::size_t most_sets = 2000;

/// What the requirements ask of a filter besides limits of its own figures.
struct FilterNeeds {
  bool sigma = false, worst_case = false;
  const FilterFigure* minimized = nullptr;
};

FilterNeeds needs_of(const Spec& spec, std::size_t filter, std::optional<std::size_t> goal) {
  FilterNeeds needs;
  for (std::size_t i = 0; i < spec.requirements.size(); ++i) {
    const Requirement& r = spec.requirements[i];
    if (r.filter != static_cast<std::ptrdiff_t>(filter)) continue;
    if (!r.limits_error()) {
      if (goal == i) needs.minimized = r.figure;
      continue;
    }
    (r.bound == Bound::worst_case ? needs.worst_case : needs.sigma) = true;
  }
  if (!needs.worst_case && !needs.minimized) needs.sigma = true;
  return needs;
}

/// A candidate with the numbers that it is compared by.
struct ComparedFilter {
  FilterCandidate candidate;
  Norms norms;
  std::vector<double> criteria;
};

bool equals_in_all(const ComparedFilter& a, const ComparedFilter& b) {
  for (std::size_t i = 0; i < a.criteria.size(); ++i)
    if (a.criteria[i] > b.criteria[i]) return false;
  return true;
}

std::vector<ComparedFilter> undominated(std::vector<ComparedFilter> all, bool within_families) {
  std::vector<ComparedFilter> kept;
  for (std::size_t i = 0; i < all.size(); ++i) {
    bool dominated = false;
    for (std::size_t k = 0; k < all.size() && !dominated; ++k) {
      if (k == i || !equals_in_all(all[k], all[i])) continue;
      const bool related = all[k].candidate.family == all[i].candidate.family &&
                           all[k].candidate.order == all[i].candidate.order;
      dominated = (related || !within_families) && (all[k].criteria != all[i].criteria || k < i);
    }
    if (!dominated) kept.push_back(all[i]);
  }
  std::ranges::stable_sort(
      kept, [](const ComparedFilter& a, const ComparedFilter& b) { return a.candidate.h2 < b.candidate.h2; });
  return kept;
}

std::string obstacle_of(const NamedFilter& filter, const FilterRange& range, const FilterScan& scan) {
  std::string text = "no low-pass of filter " + quoted(filter.name) + " is within its limits: of " +
                     counted(scan.filters, "filter");
  if (scan.filters == 0)
    return "no family has a low-pass for filter " + quoted(filter.name) + " in these orders and cut-offs";
  if (!range.tracking && !scan.any_true_gain)
    return text + ", none passes slow motion with a gain of 1 within 1 %; state `tracking` to admit others";
  if (range.delay)
    text += ", the least delay is " + readable(scan.least_delay, "s") + " (at most " +
            readable(*range.delay, "s") + ")";
  if (range.tracking)
    text += ", the least tracking error up to " + readable(range.tracking->band, "Hz") + " is " +
            significant(100 * scan.least_tracking, 3) + " % (at most " +
            significant(100 * range.tracking->at_most, 3) + " %)";
  return text + "; the requirements on the filter count as well";
}

/// Adds the ratios of sigma behind the candidates of all errors other than quantization.
void add_ratios(const DesignProblem& problem, std::vector<ComparedFilter>& all) {
  for (const auto& [stated, joint] : problem.with_slow_errors()) {
    Spec spec = *stated;
    spec.filters.clear();
    for (const ComparedFilter& c : all) spec.filters.push_back({"", c.candidate.filter, c.norms});
    for (const IndependentError& source : effect_report(spec).sources)
      for (std::size_t i = 0; i < all.size() && i < source.sigma_ratios.size(); ++i)
        all[i].criteria.push_back(source.sigma_ratios[i]);
  }
}

/// Adds the norms of the controllers whose torques are limited and whose velocity the filter estimates.
void add_torques(const Spec& spec, const std::string& velocity, ComparedFilter& c) {
  for (const Requirement& r : spec.requirements) {
    if (!r.limits_error() || r.filter < 0) continue;
    const NamedFilter& f = spec.filters[r.filter];
    if (!f.controller) continue;
    JointController controller = spec.model.control->joints[f.joints.front()];
    if (controller.velocity != velocity) continue;
    controller.velocity_filter = c.candidate.filter;
    const Norms n = norms(controller_of(controller, spec.model.control->sample_rate));
    c.criteria.push_back(r.bound == Bound::worst_case ? n.l1.upper : n.h2);
    c.criteria.push_back(std::abs(n.dc_gain));
  }
}

/// Numbers that no other candidate equals, so that none excludes it.
void keep_apart(ComparedFilter& c) {
  c.criteria.insert(c.criteria.end(),
                    {c.candidate.cutoff, -c.candidate.cutoff, c.candidate.h2, -c.candidate.h2});
}

/// Adds what the loops whose velocity the filter estimates make of it, where they are in the requirements; a
/// number of its own where that is not known at all configurations, so that no other candidate excludes it.
void add_loops(const Spec& spec, const NamedFilter& stated, ComparedFilter& c) {
  if (!spec.model.control) return;
  const auto& signals = all_signals(spec.model);
  const bool closed = std::ranges::any_of(spec.requirements, [&](const Requirement& r) {
    return r.limits_error() && is_closed(signals[r.signal]);
  });
  if (!closed && !any_of_control(spec)) return;
  std::vector<NamedFilter> filters = spec.filters;
  for (NamedFilter& f : filters)
    if (f.name == stated.name) f.filter = c.candidate.filter;
  Spec with = spec;
  with.model.control = with_velocity_filters(spec.model.control, filters);
  const Control& control = *with.model.control;
  bool known = !(closed && control.tip) && with.model.transmission.coupling.is_identity();
  for (std::size_t j = 0; j < control.joints.size() && closed; ++j) {
    if (control.joints[j].velocity != stated.name || !has_loop(control, with.model.chain, j)) continue;
    known = known && control.joints[j].inertia;
    if (!known) break;
    const auto loop = qerr::closed(loop_of(control, j, *control.joints[j].inertia));
    for (const auto part : {&ClosedLoop::motion, &ClosedLoop::torque}) {
      const Norms n = loop ? norms((*loop).*part) : Norms{1e300, 0, {0, 1e300}, 0};
      c.criteria.insert(c.criteria.end(), {n.h2, n.l1.upper, std::abs(n.dc_gain)});
    }
  }
  if (closed && !known) keep_apart(c);
  if (!any_of_control(spec)) return;
  const ControlReport report = control_report(with, true);
  for (const Requirement& r : with.requirements) {
    if (!r.of_control) continue;
    const double value = control_value(r, with, report);
    c.criteria.push_back(std::isnan(value) ? 1e300 : r.at_least ? -value : value);
  }
}

std::vector<ComparedFilter> candidates_of(const DesignProblem& problem, const FilterOptions& options,
                                          const std::vector<double>& limits, std::optional<std::size_t> goal,
                                          const DesignRequest& request, std::vector<std::string>& obstacles) {
  const Spec& spec = problem.base();
  const NamedFilter& stated = spec.filters[options.filter];
  const FilterNeeds needs = needs_of(spec, options.filter, goal);
  const auto accepts = [&](const Filter& filter) {
    std::optional<Norms> known;
    for (std::size_t i = 0; i < spec.requirements.size(); ++i) {
      const Requirement& r = spec.requirements[i];
      if (!r.figure || r.filter != static_cast<std::ptrdiff_t>(options.filter) || !std::isfinite(limits[i]))
        continue;
      if (r.figure->norm && !known) known = norms(filter);
      const auto value = r.figure->value(filter, known.value_or(Norms{}));
      if (!value || !(r.at_least ? *value >= limits[i] : *value <= limits[i])) return false;
    }
    return true;
  };
  const FilterScan scan =
      filter_candidates(options.range, stated.filter.derivative, stated.filter.sample_rate, accepts);
  std::vector<ComparedFilter> all;
  for (const FilterCandidate& c : scan.candidates) {
    ComparedFilter compared{c, {}, {}};
    if (needs.sigma) compared.criteria.push_back(c.h2);
    if (needs.worst_case || (needs.minimized && needs.minimized->norm)) {
      compared.norms = norms(c.filter);
      if (!std::isfinite(compared.norms.l1.upper)) continue;
    }
    if (needs.worst_case) {
      compared.criteria.push_back(compared.norms.l1.upper);
      compared.criteria.push_back(stated.filter.derivative == 0 ? std::abs(compared.norms.dc_gain) : 0);
    }
    if (needs.minimized) {
      const auto value = needs.minimized->value(c.filter, compared.norms);
      if (!value) continue;
      compared.criteria.push_back(*value);
    }
    if (request.gains.empty()) {
      add_torques(spec, stated.name, compared);
      add_loops(spec, stated, compared);
    } else {
      keep_apart(compared);  // a filter that is better with one gain may not be with another
    }
    all.push_back(std::move(compared));
  }
  if (needs.sigma) add_ratios(problem, all);
  all = undominated(std::move(all), request.encoders.empty());
  for (ComparedFilter& c : all) c.norms = norms(c.candidate.filter);
  if (all.empty()) obstacles.push_back(obstacle_of(stated, options.range, scan));
  return all;
}

double log_noise(const FilterSet& set) {
  double sum = 0;
  for (const DesignedFilter& f : set.designed) sum += std::log(f.filter.norms.h2);
  return sum;
}

void require_few(std::size_t sets, const Place& place, const std::string& key) {
  if (sets > most_sets)
    throw Error(place, key, "gives more than 2000 combinations of filters and gains that none excels in all",
                counted(sets, "combination"), "narrow families, orders, cut-offs or gains");
}

void vary_gains(std::vector<FilterSet>& sets, const GainOptions& options, const Spec& spec) {
  require_few(sets.size() * options.values.size(), options.place, "design.gains");
  std::vector<FilterSet> all;
  for (const FilterSet& set : sets)
    for (const double value : options.values) {
      FilterSet& added = all.emplace_back(set);
      Control control = *set.control;
      for (const std::size_t j : options.joints) {
        (options.key == "kp" ? control.joints[j].kp : control.joints[j].kd) = value;
        added.gains.push_back({spec.model.chain.independent[j].name, options.key, value});
      }
      added.control = with_velocity_filters(std::make_shared<const Control>(control), added.filters);
      update_controllers(*added.control, added.filters);
    }
  sets = std::move(all);
}

}  // namespace

FilterSets filter_sets(const DesignProblem& problem, const DesignRequest& request,
                       const std::vector<double>& limits, std::optional<std::size_t> goal) {
  FilterSets result{{{problem.base().filters, {}, {}, problem.base().model.control}}, {}};
  for (const FilterOptions& options : request.filters) {
    const std::vector<ComparedFilter> candidates =
        candidates_of(problem, options, limits, goal, request, result.obstacles);
    require_few(result.sets.size() * candidates.size(), options.place, "design.filters");
    std::vector<FilterSet> all;
    for (const FilterSet& set : result.sets)
      for (const ComparedFilter& c : candidates) {
        FilterSet& added = all.emplace_back(set);
        NamedFilter& filter = added.filters[options.filter];
        filter.filter = c.candidate.filter;
        filter.norms = c.norms;
        filter.designed = nullptr;  // describes the filter that is replaced
        added.control = with_velocity_filters(problem.base().model.control, added.filters);
        if (added.control) update_controllers(*added.control, added.filters);
        added.designed.push_back({filter.name,
                                  c.candidate.family,
                                  c.candidate.order,
                                  c.candidate.cutoff,
                                  filter,
                                  c.candidate.delay,
                                  c.candidate.tracking,
                                  options.range.tracking ? options.range.tracking->band : 0,
                                  {}});
      }
    result.sets = std::move(all);
  }
  std::ranges::stable_sort(
      result.sets, [](const FilterSet& a, const FilterSet& b) { return log_noise(a) < log_noise(b); });
  for (const GainOptions& options : request.gains) vary_gains(result.sets, options, problem.base());
  return result;
}

SpecChange lowpass_change(const DesignedFilter& f) {
  return {"filters." + f.name + ".lowpass",
          mapping_node({{"family", scalar_node(f.family)},
                        {"order", scalar_node(std::to_string(f.order))},
                        {"cutoff", scalar_node(shortest(f.cutoff) + " Hz")}})};
}

void compare_with_best(DesignedFilter& f) {
  if (!f.tracking || !(*f.tracking > 0) || !(*f.tracking < 0.9)) return;
  // Memory beyond two periods of the band's end, and twice the time in which the chosen one settles, changes
  // little; 4000 taps take a few ms.
  constexpr double most_taps = 4000;
  const double rate = f.filter.filter.sample_rate;
  const double settling = settling_time(f.filter.filter).value_or(0);
  FirTask task;
  task.taps =
      static_cast<std::size_t>(std::min(most_taps, std::ceil(rate * std::max(2 / f.band, 2 * settling))));
  task.derivative = f.filter.filter.derivative;
  task.sample_rate = rate;
  task.band = f.band;
  task.tracking = *f.tracking;
  task.gain = low_frequency_gain(f.filter.filter);
  const QuietestFir fir = quietest_fir(task);
  if (fir.converged && fir.h2_bound > 0) f.best_linear = {task.taps, fir.h2, fir.h2_bound};
}

}  // namespace qerr
