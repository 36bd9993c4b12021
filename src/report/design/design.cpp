#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/text.hpp"
#include "input/read_sections.hpp"
#include "input/yaml_tree.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figures.hpp"
#include "report/design/design_solver.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

constexpr double relaxed = 0.1;   ///< part of a limit, for the prices of requirements
constexpr int front_points = 12;  ///< searches for the Pareto front
constexpr double work_of_alternative = 1.5e9;
constexpr double none = std::numeric_limits<double>::infinity();
constexpr double millionth = 1e-6;
constexpr double highest_budget = 1e12;  ///< no design costs more

class DesignJob {
 public:
  DesignJob(const SpecVariants& variants, const DesignOptions& options)
      : variants_(variants), options_(options), request_(*variants.base().design) {
    stated_ = variants.base().requirements.size();
    std::vector<Node> more;
    if (request_.minimize == DesignRequest::Minimize::figure) {
      goal_ = stated_ + more.size();
      more.push_back(request_.figure);
    }
    if (!options.pareto.empty()) {
      pareto_ = stated_ + more.size();
      try {
        more.push_back(pareto_entry(options.pareto));
      } catch (const Error& e) {  // the figure is of the command line
        throw Error(e.faults(), Trouble::usage);
      }
    }
    add_sampled_maxima(more);
    refuse_motion_of_chosen_filters();
    problem_ = std::make_unique<DesignProblem>(variants, request_, more, options.workspace);
    if (!problem_->obstacles().empty()) return;
    FilterSets sets = filter_sets(*problem_, request_, stated_limits(problem_->base(), stated_), goal_);
    filter_obstacles_ = std::move(sets.obstacles);
    if (!sets.sets.empty())
      for (const DesignedFilter& f : sets.sets.front().designed) variants.variant({lowpass_change(f)});
    solver_ = std::make_unique<DesignSolver>(*problem_, std::move(sets.sets), options.search_progress);
  }

  DesignReport report() {
    begin();
    report_.obstacles = problem_->obstacles();
    if (!solver_ || solver_->sets().empty()) {
      append(report_.obstacles, filter_obstacles_);
      return std::move(report_);
    }
    DesignQuery query;
    query.limits = stated_limits(problem_->base(), stated_);
    if (request_.budget)
      query.most =
          static_cast<std::int64_t>(std::floor(std::min(*request_.budget, highest_budget) / millionth + 0.5));
    const DesignFindings found = solver_->best(query, goal_, margins());
    report_.proven = found.proven;
    if (!found.proven && !goal_ && found.bound < std::numeric_limits<std::int64_t>::max())
      report_.bound = millionth * static_cast<double>(found.bound);
    if (!found.margin_proven)
      report_.warnings.emplace_back(
          "of the designs that cost as much, one with a better margin may exist: the work of a search ended");
    if (found.best.empty()) {
      explain_infeasible(query);
      return std::move(report_);
    }
    report_.warnings.insert(report_.warnings.end(), report_.left_out.begin(), report_.left_out.end());
    report_.optimal = design_of(found.best[0]);
    state_assumption(found.best[0]);
    if (found.best.size() > 1) report_.runner_up = design_of(found.best[1]);
    if (!options_.target.empty()) report_.written = written(found.best[0]);
    find_influences(found.best[0]);
    if (!options_.alternatives) return std::move(report_);
    if (!goal_) price_requirements(query, found.best[0]);
    make_front(query, found.best[0]);
    return std::move(report_);
  }

 private:
  void begin() {
    report_.spec = variants_.base();
    report_.price_unit = request_.price_unit;
    report_.by_bits = problem_->by_bits();
    report_.left_out = problem_->left_out();
    report_.budget = request_.budget;
    report_.goal = request_.minimize == DesignRequest::Minimize::price        ? "price"
                   : request_.minimize == DesignRequest::Minimize::resolution ? "resolution"
                                                                              : requirement(*goal_).name();
    if (goal_) report_.goal_unit = requirement(*goal_).unit;
    report_.warnings = report_.spec.warnings;
    std::erase_if(report_.warnings, [](const std::string& w) { return w.starts_with("sweep:"); });
    if (problem_->base().configurations.method != SamplingMethod::list &&
        size(problem_->base().configurations) > exact_percentiles_limit)
      report_.warnings.emplace_back("percentiles are counted in bins: right to 1e-3 relative");
  }

  const Requirement& requirement(std::size_t i) const { return problem_->base().requirements[i]; }

  /// Of a proven maximum the front and the margins take the sampled one: proofs would take minutes.
  void add_sampled_maxima(std::vector<Node>& more) {
    for (std::size_t i = 0; i < stated_; ++i) {
      const Requirement& r = variants_.base().requirements[i];
      if (!r.proven) continue;
      sampled_maximum_[i] = stated_ + more.size();
      more.push_back(pareto_entry(r.quantity + " max"));
    }
  }

  /// The values of errors over their limits, of which the largest decides among designs that cost as much.
  std::vector<DesignGoal> margins() const {
    constexpr double no_limit = 1e100;  // as good as none
    std::vector<DesignGoal> goals;
    for (std::size_t i = 0; i < stated_; ++i) {
      const Requirement& r = requirement(i);
      if (!r.limits_error() || !(r.limit > 0 && r.limit < no_limit)) continue;
      const auto sampled = sampled_maximum_.find(i);
      goals.push_back({sampled == sampled_maximum_.end() ? i : sampled->second, r.limit});
    }
    return goals;
  }

  Node pareto_entry(const std::string& figure) const {
    // A quantity, and perhaps its statistic behind a blank.
    const std::size_t blank = figure.find(' ');
    Node quantity = scalar_node(figure.substr(0, blank));
    quantity.place = {"--pareto", 0, 0};
    if (blank == std::string::npos) return figure_entry({&quantity, "--pareto"}, nullptr, variants_.base());
    Node statistic = scalar_node(figure.substr(blank + 1));
    statistic.place = quantity.place;
    return figure_entry({&quantity, "--pareto"}, &statistic, variants_.base());
  }

  void refuse_motion_of_chosen_filters() const {
    for (const Requirement& r : variants_.base().requirements)
      for (const FilterOptions& f : request_.filters)
        if (r.limits_error() && r.bound == Bound::sigma_in_motion &&
            static_cast<std::size_t>(r.filter) == f.filter)
          throw requirement_error(r, "sigma_in_motion behind a filter that is itself chosen is not supported",
                                  "require sigma, or choose the filter first", r.name());
  }

  std::vector<DesignedEncoder> encoders_of(const OptionChoice& choice) const {
    std::vector<DesignedEncoder> list;
    for (std::size_t j = 0; j < choice.size(); ++j) {
      const PricedOption& o = problem_->options()[j][choice[j]];
      if (problem_->chosen(j))
        list.push_back({problem_->base().model.chain.independent[j].name, o.option.name, o.price, o.bits});
    }
    return list;
  }

  Design design_of(const FoundDesign& found) const {
    Design d;
    d.encoders = encoders_of(found.choice);
    std::tie(d.price, d.bits) = costs(found);
    d.filters = solver_->set(found).designed;
    d.gains = solver_->set(found).gains;
    for (DesignedFilter& f : d.filters) compare_with_best(f);
    d.results = problem_->results(found.choice, solver_->set(found));
    if (goal_) d.minimized = d.results[*goal_].value;
    d.results.resize(stated_);
    for (const SpecChange& change : changes(found))
      d.changes_by_set.push_back(change.first + '=' + flow(change.second));
    return d;
  }

  std::vector<SpecChange> changes(const FoundDesign& found) const {
    std::vector<SpecChange> all = problem_->changes(found.choice);
    for (const DesignedFilter& f : solver_->set(found).designed) all.push_back(lowpass_change(f));
    for (const DesignedGain& g : solver_->set(found).gains)
      all.emplace_back("control.joints." + g.joint + '.' + g.key, scalar_node(shortest(g.value)));
    return all;
  }

  std::string written(const FoundDesign& found) const {
    std::string remark = "chosen by qerr design, minimize: " + report_.goal;
    for (const DesignedEncoder& e : report_.optimal->encoders) remark += "\n  " + e.joint + ": " + e.name;
    return changed_spec(report_.spec, changes(found), problem_->effects(found.choice),
                        joined(lines_of(remark), "\n", [](const std::string& line) { return escaped(line); }),
                        options_.target);
  }

  /// How slow errors of a design are judged where sigma behind a filter is required.
  void state_assumption(const FoundDesign& found) {
    const bool asked = std::ranges::any_of(problem_->base().requirements, [](const Requirement& r) {
      return r.limits_error() && r.filter >= 0 && r.bound == Bound::sigma;
    });
    if (!asked) return;
    const Spec spec = problem_->variant(found.choice, solver_->set(found));
    const std::string text = slow_error_assumption(spec, effect_report(spec).shares);
    if (!text.empty()) report_.warnings.push_back(text);
  }

  /// Nothing feasible: the least that each requirement can reach, and what is in the way of all together.
  void explain_infeasible(const DesignQuery& query) {
    if (!report_.proven) {
      report_.obstacles.push_back("no design was found within the work of a search, and none is excluded");
      return;
    }
    if (request_.budget) {
      DesignQuery unlimited = query;
      unlimited.most = std::int64_t{1} << 62;
      unlimited.wanted = 1;
      const DesignFindings found = solver_->find(unlimited);
      if (!found.best.empty()) {
        report_.obstacles.push_back("the requirements cost at least " +
                                    significant(millionth * static_cast<double>(found.best[0].cost), 6) +
                                    ", the budget is " + significant(*request_.budget, 6));
        return;
      }
    }
    if (!explain_alone()) explain_together();
    report_.obstacles.insert(report_.obstacles.end(), report_.left_out.begin(), report_.left_out.end());
  }

  DesignQuery without_limits() const {
    DesignQuery query;
    query.limits.assign(problem_->base().requirements.size(), none);
    query.wanted = 1;
    query.work = work_of_alternative;
    return query;
  }

  /// What each requirement alone can reach at best. @returns whether one of them is in the way
  bool explain_alone() {
    bool any = false;
    for (std::size_t i = 0; i < stated_; ++i) {
      const Requirement& r = requirement(i);
      bool proven = true;
      double value = 0;
      if (r.of_control) {
        DesignQuery query = without_limits();
        query.limits[i] = r.limit;
        const DesignFindings found = solver_->find(query);
        if (!found.best.empty() || !found.proven) continue;
        any = true;
        report_.obstacles.push_back(r.name() + (r.at_least ? " of at least " : " of at most ") +
                                    readable(r.limit, r.unit) + " is met by no choice");
        continue;
      }
      if (r.figure) {
        value = best_of_filters(r);
      } else if (r.limits_error()) {
        DesignQuery query = without_limits();
        value = solver_->value(*solver_->least({{i, 1}}, query, proven), i);
      } else {
        continue;  // options that do not meet it are left out
      }
      if (r.met_by(value)) continue;
      any = true;
      report_.obstacles.push_back(
          r.name() + " is " + readable(value, r.unit) + (r.at_least ? " at most" : " at least") +
          (proven ? "" : ", as far as the work of a search goes,") + " whatever is chosen, " +
          (r.at_least ? "at least " : "at most ") + readable(r.limit, r.unit) + " is required");
    }
    find_nearest();
    return any;
  }

  /// The value of a filter's figure that comes nearest to its limit.
  double best_of_filters(const Requirement& r) const {
    double best = r.at_least ? -none : none;
    for (const FilterSet& set : solver_->sets()) {
      const NamedFilter& f = set.filters[r.filter];
      const double value = r.figure->value(f.filter, f.norms).value_or(r.at_least ? -none : none);
      best = r.at_least ? std::max(best, value) : std::min(best, value);
    }
    return best;
  }

  /// The design that is nearest to the limits of all errors.
  void find_nearest() {
    DesignQuery query = without_limits();
    bool proven = true;
    const std::vector<DesignGoal> goals = margins();
    if (goals.empty()) return;
    const auto nearest = solver_->least(goals, query, proven);
    if (!nearest) return;
    report_.finest = design_of(*nearest);
    state_assumption(*nearest);
  }

  void explain_together() {
    std::string text = "each requirement can be met alone, but no design meets all of them";
    double most = 0;
    if (report_.finest)
      for (std::size_t i = 0; i < stated_; ++i)
        if (requirement(i).limits_error() && requirement(i).limit > 0)
          most = std::max(most, report_.finest->results[i].value / requirement(i).limit);
    if (most > 1) text += ": the nearest one would need limits " + significant(most, 4) + " times as large";
    report_.obstacles.push_back(text);
  }

  void find_influences(const FoundDesign& best) {
    const ChoiceProblem& problem = solver_->problem(best.set);
    for (std::size_t i = 0; i < stated_; ++i) {
      const ChoiceFigure& figure = problem.figures[i];
      const bool varies =
          figure.sums.empty() || std::ranges::any_of(figure.sums, [&](const WeightedSum& sum) {
            return std::ranges::any_of(sum.columns, [&](const WeightedColumn& c) {
              const bool moves = std::any_of(c.coefficients, c.coefficients + problem.configurations,
                                             [](double a) { return a > 1e-12; });
              return moves &&
                     std::ranges::any_of(c.weights, [&](double w) { return w != c.weights.front(); });
            });
          });
      const bool of_loop = requirement(i).of_control && request_.filters.size() + request_.gains.size() > 0;
      if (!varies && !of_loop && requirement(i).counter < 0 && !filter_chosen(requirement(i).filter))
        report_.without_influence.push_back(i);
    }
  }

  void price_requirements(const DesignQuery& query, const FoundDesign& best) {
    for (std::size_t i = 0; i < stated_; ++i) {
      if (requirement(i).counter >= 0) continue;  // another limit admits other options
      DesignQuery looser = query;
      looser.limits[i] *= requirement(i).at_least ? 1 - relaxed : 1 + relaxed;
      looser.wanted = 1;
      looser.known = {best};
      looser.work = work_of_alternative;
      // A looser limit of a filter's figure admits further filters.
      const bool of_filter = requirement(i).figure && filter_chosen(requirement(i).filter);
      const DesignFindings found = of_filter ? find_with_other_filters(looser) : solver_->find(looser);
      RequirementPrice price{i, relaxed, {}, {}, found.proven};
      if (!found.best.empty()) std::tie(price.price, price.bits) = costs(found.best[0]);
      report_.requirement_prices.push_back(price);
    }
  }

  bool filter_chosen(std::ptrdiff_t filter) const {
    return std::ranges::any_of(request_.filters, [&](const FilterOptions& f) {
      return static_cast<std::ptrdiff_t>(f.filter) == filter;
    });
  }

  DesignFindings find_with_other_filters(DesignQuery query) {
    FilterSets sets = filter_sets(*problem_, request_, query.limits, goal_);
    query.known.clear();
    return DesignSolver(*problem_, std::move(sets.sets), options_.search_progress).find(query);
  }

  /// The sums of prices, if all are stated, and of bits.
  std::pair<std::optional<double>, double> costs(const FoundDesign& found) const {
    std::optional<double> price = 0.0;
    double bits = 0;
    for (const DesignedEncoder& e : encoders_of(found.choice)) {
      price = price && e.price ? std::optional(*price + *e.price) : std::nullopt;
      bits += e.bits;
    }
    if (price) price = std::round(*price / millionth) * millionth;
    return {price, bits};
  }

  /// The requirement on encoders whose limit is used most.
  std::optional<std::size_t> tightest() const {
    std::optional<std::size_t> best;
    double most = -1;
    for (std::size_t i = 0; i < stated_; ++i) {
      const Requirement& r = requirement(i);
      const double usage = !r.limits_error() ? -1 : report_.optimal->results[i].value / r.limit;
      if (usage > most) {
        most = usage;
        best = i;
      }
    }
    return best;
  }

  /// Costs as a function of a figure's limit, from the cheapest design without it to the finest one.
  void make_front(const DesignQuery& query, const FoundDesign& best) {
    auto p = pareto_ ? pareto_ : goal_ ? goal_ : tightest();
    if (pareto_ && !requirement(*p).limits_error())
      throw Error(requirement(*p).place, "--pareto", "encoders do not change a figure of a filter",
                  quoted(requirement(*p).name()), "name an error, such as position.xyz.sigma",
                  Trouble::usage);
    if (p && sampled_maximum_.contains(*p)) p = sampled_maximum_.at(*p);
    if (!p || !requirement(*p).limits_error() || encoders_of(best.choice).empty()) return;
    report_.pareto_figure = requirement(*p).name();
    report_.pareto_unit = requirement(*p).unit;
    DesignQuery free = query;
    free.wanted = 1;
    free.work = work_of_alternative;
    for (std::size_t i = 0; i < stated_; ++i)
      if (requirement(i).name() == report_.pareto_figure ||
          (sampled_maximum_.contains(i) && sampled_maximum_.at(i) == *p))
        free.limits[i] = none;
    free.limits[*p] = none;
    const DesignFindings cheapest = solver_->find(free);
    if (cheapest.best.empty()) return;
    add_point(cheapest, free, *p);
    DesignQuery finest = free;
    bool proven = true;
    const double most = report_.pareto.front().value;
    const auto reached = solver_->least({{*p, 1}}, finest, proven);
    const double least = reached ? solver_->value(*reached, *p) : most;
    for (int i = 1; i <= front_points && least > 0 && most > least; ++i) {
      const double fraction = static_cast<double>(i) / front_points;
      free.limits[*p] = most * std::pow(least / most, fraction) * (i == front_points ? 1 + 1e-9 : 1);
      if (free.limits[*p] >= report_.pareto.back().value) continue;  // that design meets it as well
      const DesignFindings found = solver_->find(free);
      if (found.best.empty()) break;
      add_point(found, free, *p);
    }
    find_uniform(best.set, *p);
  }

  /// Each option that all chosen joints have, at all of them: the rows of a catalogue beside the front.
  void find_uniform(std::size_t set, std::size_t p) {
    constexpr std::size_t most = 60;
    const auto& all = problem_->options();
    std::size_t first = 0;
    while (!problem_->chosen(first)) ++first;
    for (const PricedOption& option : all[first]) {
      FoundDesign d{0, set, {}};
      for (std::size_t j = 0; j < all.size(); ++j) {
        const auto same = std::ranges::find_if(all[j], [&](const PricedOption& o) {
          return !problem_->chosen(j) || o.option.name == option.option.name;
        });
        if (same == all[j].end()) break;
        d.choice.push_back(static_cast<std::size_t>(same - all[j].begin()));
        d.cost += same->cost;
      }
      if (d.choice.size() < all.size() || report_.uniform.size() == most) continue;
      const auto [price, bits] = costs(d);
      report_.uniform.push_back({price, bits, solver_->value(d, p), encoders_of(d.choice), true});
    }
  }

  void add_point(const DesignFindings& found, DesignQuery query, std::size_t p) {
    bool proven = found.proven;
    query.most = found.best[0].cost;
    query.known = {found.best[0]};
    const FoundDesign d = solver_->least({{p, 1}}, query, proven).value_or(found.best[0]);
    const auto [price, bits] = costs(d);
    ParetoPoint point{price, bits, solver_->value(d, p), encoders_of(d.choice), proven};
    const auto cost = [&](const ParetoPoint& of) { return report_.by_bits ? of.bits : of.price.value_or(0); };
    // A finer design at the same cost replaces the one before.
    if (!report_.pareto.empty() && cost(report_.pareto.back()) >= cost(point)) report_.pareto.pop_back();
    report_.pareto.push_back(std::move(point));
  }

  const SpecVariants& variants_;
  const DesignOptions& options_;
  const DesignRequest& request_;
  std::size_t stated_ = 0;
  std::optional<std::size_t> goal_, pareto_;
  std::map<std::size_t, std::size_t> sampled_maximum_;  ///< of a requirement on a proven one
  std::unique_ptr<DesignProblem> problem_;
  std::unique_ptr<DesignSolver> solver_;
  std::vector<std::string> filter_obstacles_;
  DesignReport report_;
};

}  // namespace

DesignReport design(const SpecVariants& variants, const DesignOptions& options) {
  if (!variants.base().design)
    throw spec_error(variants.base(), "design",
                     "the spec has no section of this name: nothing is to be chosen", "",
                     "add design: {encoders: {'*': {bits: 12..23}}} (`qerr help choice`)");
  const DesignRequest& request = *variants.base().design;
  if (variants.base().requirements.empty() && request.minimize != DesignRequest::Minimize::figure)
    throw spec_error(variants.base(), "requirements", "the spec has none: the coarsest encoders would do", "",
                     "add limits, as for `qerr check`");
  return DesignJob(variants, options).report();
}

}  // namespace qerr
