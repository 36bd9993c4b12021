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

DesignSolver::DesignSolver(DesignProblem& problem, std::vector<FilterSet> sets)
    : problem_(problem), sets_(std::move(sets)), searched_(sets_.size()) {
  for (std::size_t j = 0; j < problem.options().size(); ++j) any_encoder_ = any_encoder_ || problem.chosen(j);
}

DesignSolver::Searched& DesignSolver::searched(std::size_t set) {
  if (!searched_[set]) {
    searched_[set] = std::make_unique<Searched>(Searched{problem_.problem(sets_[set].filters), nullptr});
    searched_[set]->search = std::make_unique<EncoderSearch>(searched_[set]->problem);
  }
  return *searched_[set];
}

bool DesignSolver::filters_meet(std::size_t set, const std::vector<double>& limits) const {
  const auto& requirements = problem_.base().requirements;
  for (std::size_t i = 0; i < requirements.size(); ++i) {
    const Requirement& r = requirements[i];
    if (!r.figure || limits[i] == std::numeric_limits<double>::infinity()) continue;
    const NamedFilter& f = sets_[set].filters[static_cast<std::size_t>(r.filter)];
    const std::optional<double> value = r.figure->value(f.filter, f.norms);
    if (!value || !(r.at_least ? *value >= limits[i] : *value <= limits[i])) return false;
  }
  return true;
}

DesignFindings DesignSolver::find_in(std::size_t set, const DesignQuery& query) {
  if (!filters_meet(set, query.limits)) return {};
  ChoiceRequest request;
  request.limits = query.limits;
  const auto& requirements = problem_.base().requirements;
  for (std::size_t i = 0; i < requirements.size(); ++i)
    if (requirements[i].figure) request.limits[i] = std::numeric_limits<double>::infinity();
  request.most = query.most;
  request.wanted = query.wanted;
  request.work = query.work;
  for (const FoundDesign& d : query.known)
    if (d.set == set || sets_.size() > 1) request.known.push_back(d.choice);
  for (const FoundDesign& d : query.excluded)
    if (d.set == set || any_encoder_) request.excluded.push_back(d.choice);
  const ChoiceResult result = searched(set).search->find(request);
  DesignFindings findings{{}, result.proven, result.bound};
  for (const OptionChoice& choice : result.best)
    findings.best.push_back({price_of(searched(set).problem, choice), set, choice});
  return findings;
}

DesignFindings DesignSolver::find(const DesignQuery& query) {
  DesignFindings all{{}, true, std::numeric_limits<std::int64_t>::max()};
  for (std::size_t s = 0; s < sets_.size(); ++s) {
    DesignQuery here = query;
    if (all.best.size() >= query.wanted) here.most = std::min(query.most, all.best.back().cost);
    const DesignFindings found = find_in(s, here);
    if (!found.proven) {
      all.proven = false;
      all.bound = std::min(all.bound, found.bound);
    }
    for (const FoundDesign& d : found.best) {
      const bool known = std::any_of(all.best.begin(), all.best.end(), [&](const FoundDesign& other) {
        return any_encoder_ && other.choice == d.choice;
      });
      if (!known) all.best.push_back(d);
    }
    std::stable_sort(all.best.begin(), all.best.end(),
                     [](const FoundDesign& a, const FoundDesign& b) { return a.cost < b.cost; });
    if (all.best.size() > query.wanted) all.best.resize(query.wanted);
  }
  if (!all.best.empty()) all.bound = std::min(all.bound, all.best.front().cost);
  return all;
}

double DesignSolver::value(const FoundDesign& d, std::size_t requirement) const {
  // Requirements on proven maxima need no proof for another figure's value.
  const std::vector<Requirement>& all = problem_.base().requirements;
  const std::vector<double> none(all.size(), std::numeric_limits<double>::infinity());
  const std::vector<double>* const limits = all[requirement].proven ? nullptr : &none;
  return problem_.results(d.choice, sets_[d.set].filters, limits)[requirement].value;
}

/// The least value in one filter set below the query's limit of the goal, by bisection over limits: each
/// search finds a design with a lower value, or proves that there is none.
std::optional<FoundDesign> DesignSolver::least_in(std::size_t set, std::size_t goal, DesignQuery query,
                                                  bool& proven) {
  constexpr double below = 1 - 1e-10, near = 1.001;
  query.wanted = 1;
  std::optional<FoundDesign> best;
  const auto look = [&](double limit) {
    query.limits[goal] = limit;
    const DesignFindings found = find_in(set, query);
    proven = proven && found.proven;
    if (!found.best.empty()) best = found.best.front();
    return !found.best.empty();
  };
  if (!look(query.limits[goal])) return std::nullopt;
  const ChoiceProblem& problem = searched(set).problem;
  const PermittedOptions all(option_offsets(problem).back(), 1);
  double high = value(*best, goal);
  double low = problem.figures[goal].sums.empty()
                   ? 0
                   : figure_value(problem.figures[goal],
                                  least_weights(problem.figures[goal], option_offsets(problem), all),
                                  problem.configurations);
  low = std::max(low, 1e-9 * high);
  while (high > low && proven) {
    const bool last = high < near * low;
    const double limit = last ? below * high : std::sqrt(low * high);
    if (look(limit)) {
      high = value(*best, goal);
    } else {
      if (last) break;
      low = limit;
    }
  }
  look(high / below);  // the cheapest one of this value
  return best;
}

DesignFindings DesignSolver::minimize_of_filter(std::size_t goal, const DesignQuery& query) {
  const Requirement& r = problem_.base().requirements[goal];
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t s = 0; s < sets_.size(); ++s) {
    const NamedFilter& f = sets_[s].filters[static_cast<std::size_t>(r.filter)];
    if (const auto v = r.figure->value(f.filter, f.norms)) order.emplace_back(*v, s);
  }
  std::sort(order.begin(), order.end());
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

DesignFindings DesignSolver::minimize(std::size_t goal, const DesignQuery& query) {
  if (problem_.base().requirements[goal].figure) return minimize_of_filter(goal, query);
  DesignFindings findings;
  DesignQuery next = query;
  while (findings.best.size() < query.wanted) {
    std::optional<FoundDesign> best;
    next.limits[goal] = std::numeric_limits<double>::infinity();
    for (std::size_t s = 0; s < sets_.size(); ++s)
      if (auto found = least_in(s, goal, next, findings.proven)) {
        best = std::move(found);
        next.limits[goal] = value(*best, goal) * (1 - 1e-10);
      }
    if (!best) break;
    findings.best.push_back(*best);
    next.excluded.push_back(*best);
  }
  return findings;
}

}  // namespace qerr
