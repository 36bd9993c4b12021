#include "report/design/design_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace qerr {

std::vector<double> stated_limits(const Spec& spec, std::size_t stated) {
  std::vector<double> limits;
  for (std::size_t i = 0; i < spec.requirements.size(); ++i)
    limits.push_back(i < stated ? spec.requirements[i].limit : std::numeric_limits<double>::infinity());
  return limits;
}

DesignSolver::DesignSolver(DesignProblem& problem, std::vector<FilterSet> sets, SearchProgress progress)
    : problem_(problem), sets_(std::move(sets)), searched_(sets_.size()), progress_(std::move(progress)) {
  for (std::size_t j = 0; j < problem.options().size(); ++j) any_encoder_ = any_encoder_ || problem.chosen(j);
  for (FilterSet& set : sets_)
    set.evaluated = std::make_shared<std::map<OptionChoice, std::vector<RequirementResult>>>();
}

DesignSolver::Searched& DesignSolver::searched(std::size_t set) {
  if (!searched_[set]) {
    searched_[set] = std::make_unique<Searched>(Searched{problem_.problem(sets_[set]), nullptr});
    searched_[set]->search = std::make_unique<EncoderSearch>(searched_[set]->problem);
  }
  return *searched_[set];
}

bool DesignSolver::filters_meet(std::size_t set, const std::vector<double>& limits) const {
  const auto& requirements = problem_.base().requirements;
  for (std::size_t i = 0; i < requirements.size(); ++i) {
    const Requirement& r = requirements[i];
    if (!r.figure || std::isinf(limits[i])) continue;
    const NamedFilter& f = sets_[set].filters[r.filter];
    const std::optional<double> value = r.figure->value(f.filter, f.norms);
    Requirement limited = r;
    limited.limit = limits[i];
    if (!value || !limited.met_by(*value)) return false;
  }
  return true;
}

DesignFindings DesignSolver::find_in(std::size_t set, const DesignQuery& query) {
  if (!filters_meet(set, query.limits)) return {};
  ChoiceRequest request{query.limits, query.most, query.wanted, {}, {}, query.work};
  const auto& requirements = problem_.base().requirements;
  for (std::size_t i = 0; i < requirements.size(); ++i)
    if (requirements[i].of_control)
      request.limits[i] = ratio_limit(requirements[i], request.limits[i]);
    else if (!requirements[i].limits_error())
      request.limits[i] = std::numeric_limits<double>::infinity();
  ++searches_;
  if (progress_) request.progress = [this](double part) { progress_(searches_, part); };
  for (const FoundDesign& d : query.known)
    if (d.set == set || sets_.size() > 1) request.known.push_back(d.choice);
  for (const FoundDesign& d : query.excluded)
    if (d.set == set || any_encoder_) request.excluded.push_back(d.choice);
  const ChoiceResult result = searched(set).search->find(request);
  DesignFindings findings{{{}, result.proven, result.bound}};
  for (const OptionChoice& choice : result.best)
    findings.best.push_back({price_of(searched(set).problem, choice), set, choice});
  return findings;
}

DesignFindings DesignSolver::find(const DesignQuery& query) {
  DesignFindings all{{{}, true, std::numeric_limits<std::int64_t>::max()}};
  for (std::size_t s = 0; s < sets_.size(); ++s) {
    DesignQuery here = query;
    if (all.best.size() >= query.wanted) here.most = std::min(query.most, all.best.back().cost);
    const DesignFindings found = find_in(s, here);
    if (!found.proven) {
      all.proven = false;
      all.bound = std::min(all.bound, found.bound);
    }
    for (const FoundDesign& d : found.best) {
      const bool known = std::ranges::any_of(
          all.best, [&](const FoundDesign& other) { return any_encoder_ && other.choice == d.choice; });
      if (!known) all.best.push_back(d);
    }
    std::ranges::stable_sort(all.best,
                             [](const FoundDesign& a, const FoundDesign& b) { return a.cost < b.cost; });
    if (all.best.size() > query.wanted) all.best.resize(query.wanted);
  }
  if (!all.best.empty()) all.bound = std::min(all.bound, all.best.front().cost);
  return all;
}

double DesignSolver::largest(const FoundDesign& d, const std::vector<DesignGoal>& goals) const {
  // Requirements on proven maxima need no proof for another figure's value.
  const std::vector<Requirement>& all = problem_.base().requirements;
  const std::vector<double> none(all.size(), std::numeric_limits<double>::infinity());
  const bool proof =
      std::ranges::any_of(goals, [&](const DesignGoal& g) { return all[g.requirement].proven; });
  const auto results = problem_.results(d.choice, sets_[d.set], proof ? nullptr : &none);
  double most = 0;
  for (const DesignGoal& g : goals) most = std::max(most, results[g.requirement].value / g.scale);
  return most;
}

/// Relative difference within which values are equal: beyond the tolerance of the sums, so that these decide.
double DesignSolver::tie(std::size_t set, const std::vector<DesignGoal>& goals) {
  double tolerance = 0;
  for (const DesignGoal& g : goals)
    tolerance = std::max(tolerance, searched(set).problem.figures[g.requirement].tolerance);
  constexpr double beyond = 10;
  return beyond * tolerance;
}

/// The design of least largest value in one filter set, by bisection over limits: each search finds a design
/// with a lower value, or proves that there is none.
std::optional<FoundDesign> DesignSolver::least_in(std::size_t set, const std::vector<DesignGoal>& goals,
                                                  DesignQuery query, bool& proven) {
  constexpr double near = 1.001;
  query.wanted = 1;
  const std::vector<double> most = query.limits;
  std::optional<FoundDesign> best;
  const auto look = [&](double part) {
    for (const DesignGoal& g : goals)
      query.limits[g.requirement] = std::min(most[g.requirement], part * g.scale);
    const DesignFindings found = find_in(set, query);
    proven = proven && found.proven;
    if (!found.best.empty()) best = found.best.front();
    return !found.best.empty();
  };
  if (!look(std::numeric_limits<double>::infinity())) return std::nullopt;
  const ChoiceProblem& problem = searched(set).problem;
  const PermittedOptions all(option_offsets(problem).back(), 1);
  double high = largest(*best, goals), low = 0;
  for (const DesignGoal& g : goals) {
    const ChoiceFigure& figure = problem.figures[g.requirement];
    if (figure.sums.empty()) continue;
    const SumWeights weights = least_weights(figure, option_offsets(problem), all);
    low = std::max(low, figure_value(figure, weights, problem.configurations) / g.scale);
  }
  low = std::max(low, 1e-9 * high);
  // Whether any is lower is asked before each halving: what is known to begin with is often the least
  // already.
  for (bool any = true; high > low && proven;) {
    const bool last = any || high < near * low;
    const double part = last ? high * (1 - tie(set, goals)) : std::sqrt(low * high);
    if (look(part)) {
      high = largest(*best, goals);
      any = !last;
    } else {
      if (last) break;
      low = part;
    }
  }
  return best;
}

std::optional<FoundDesign> DesignSolver::least(const std::vector<DesignGoal>& goals, DesignQuery& query,
                                               bool& proven) {
  std::optional<FoundDesign> best;
  const std::vector<double> most = query.limits;
  const auto lower = [&](double part) {
    for (const DesignGoal& g : goals)
      query.limits[g.requirement] = std::min(most[g.requirement], part * g.scale);
  };
  double value = std::numeric_limits<double>::infinity();
  for (std::size_t s = 0; s < sets_.size(); ++s)
    if (auto found = least_in(s, goals, query, proven)) {
      best = std::move(found);
      value = largest(*best, goals);
      lower(value * (1 - tie(s, goals)));
    }
  if (best) lower(value * (1 + tie(best->set, goals)));
  return best;
}

DesignFindings DesignSolver::minimize_of_filter(std::size_t goal, const DesignQuery& query) {
  const Requirement& r = problem_.base().requirements[goal];
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t s = 0; s < sets_.size(); ++s) {
    const NamedFilter& f = sets_[s].filters[r.filter];
    if (const auto v = r.figure->value(f.filter, f.norms)) order.emplace_back(*v, s);
  }
  std::ranges::sort(order);
  DesignFindings findings;
  DesignQuery one = query;
  one.wanted = 1;
  for (const auto& [value, s] : order) {
    if (findings.best.size() == query.wanted) break;
    const DesignFindings found = find_in(s, one);
    findings.proven = findings.proven && found.proven;
    if (!found.best.empty()) findings.best.push_back(found.best.front());
  }
  return findings;
}

FoundDesign DesignSolver::with_best_margin(const FoundDesign& cheapest, DesignQuery query,
                                           const std::vector<DesignGoal>& margins, bool& proven) {
  // A tie is a refinement of what is proven: it takes a part of the work of a search.
  constexpr double work = 3e8;
  query.most = cheapest.cost;
  query.work = std::min(query.work, work);
  query.known = {cheapest};
  query.wanted = 2;
  if (sets_.size() == 1 && find(query).best.size() == 1) return cheapest;
  query.wanted = 1;
  std::vector<std::vector<DesignGoal>> stages{margins};
  if (margins.size() > 1)
    for (const DesignGoal& g : margins) stages.push_back({g});
  FoundDesign best = cheapest;
  for (const std::vector<DesignGoal>& goals : stages) {
    if (goals.empty() || !proven) break;
    if (const auto found = least(goals, query, proven)) best = *found;
    query.known = {best};
  }
  if (!proven) return best;
  const DesignFindings found = find(query);
  proven = found.proven;
  return found.best.empty() ? best : found.best.front();
}

DesignFindings DesignSolver::best(const DesignQuery& query, std::optional<std::size_t> goal,
                                  const std::vector<DesignGoal>& margins) {
  if (goal && problem_.base().requirements[*goal].figure) return minimize_of_filter(*goal, query);
  DesignFindings all{{{}, true, std::numeric_limits<std::int64_t>::max()}};
  while (all.best.size() < query.wanted) {
    DesignQuery next = query;
    next.wanted = 1;
    for (const FoundDesign& d : all.best) next.excluded.push_back(d);
    if (goal && !least({{*goal, 1}}, next, all.proven)) break;
    const DesignFindings found = find(next);
    all.proven = all.proven && found.proven;
    if (!found.proven) all.bound = std::min(all.bound, found.bound);
    if (found.best.empty()) break;
    all.bound = std::min(all.bound, found.best.front().cost);
    all.best.push_back(found.proven ? with_best_margin(found.best.front(), next, margins, all.margin_proven)
                                    : found.best.front());
  }
  return all;
}

}  // namespace qerr
