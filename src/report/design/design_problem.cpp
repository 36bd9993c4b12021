#include "report/design/design_problem.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "input/catalogue.hpp"
#include "input/yaml_text.hpp"
#include "report/analysis/effects.hpp"

namespace qerr {

namespace {

/// Numbers that the columns of a search may take: 4 GB.
constexpr double most_numbers = 5e8;
/// In place of infinity: an unbounded coordinate exceeds every limit, and times 0 is 0.
constexpr double beyond_all = 1e300;

Node with_requirements(const SpecVariants& variants, const std::vector<Node>& more) {
  Node root = parse_yaml(variants.base().text, variants.base().file);
  for (const SpecChange& change : in_order(spec_changes(variants.base().overrides)))
    apply_override(root, change);
  Node list{Node::Type::sequence, more.front().place, {}, false, {}, {}};
  if (const Node* stated = root.find("requirements"); stated && stated->type == Node::Type::sequence)
    list = *stated;
  list.items.insert(list.items.end(), more.begin(), more.end());
  return list;
}

ChoiceFigure::Over over_of(const Requirement& r) {
  using Over = ChoiceFigure::Over;
  return r.value == &Statistic::min    ? Over::least
         : r.value == &Statistic::mean ? Over::mean
         : r.value == &Statistic::max  ? Over::largest
                                       : Over::percentile;
}

double percentile_of(const Requirement& r) {
  for (const StatisticKind& kind : statistic_kinds())
    if (kind.value == r.value) return kind.percentile;
  return 0;
}

}  // namespace

DesignProblem::DesignProblem(const SpecVariants& variants, const DesignRequest& request,
                             const std::vector<Node>& more, const WorkspaceOptions& workspace)
    : variants_(variants), workspace_(workspace) {
  if (!more.empty()) common_.emplace_back("requirements", with_requirements(variants, more));
  base_ = variant_of({}, {});
  for (const Requirement& r : base_.requirements) {
    if (r.figure) continue;
    needs_motion_noise_ = needs_motion_noise_ || r.bound == Requirement::Bound::sigma_in_motion;
    needs_rigorous_ = needs_rigorous_ || r.bound == Requirement::Bound::worst_case_rigorous;
    if (r.at_least)
      throw Error(Fault{r.place, "requirements",
                        "at_least of an error is no limit of a design: finer encoders only lower it",
                        quoted(r.name()), "write at_most, or leave it to `qerr check`"});
  }
  workspace_.brief = !needs_rigorous_;
  read_options(request);
  make_columns();
}

Spec DesignProblem::variant_of(const std::vector<SpecChange>& changes,
                               const std::vector<Node>& effects) const {
  std::vector<SpecChange> all = common_;
  all.insert(all.end(), changes.begin(), changes.end());
  return variants_.variant(all, effects);
}

void DesignProblem::read_options(const DesignRequest& request) {
  const std::size_t n = base_.model.chain.independent.size();
  options_.assign(n, {PricedOption{}});
  for (const JointOptions& joint : request.encoders) {
    std::vector<PricedOption>& options = options_[joint.joint];
    options.clear();
    for (const EncoderOption& option : joint.options) options.push_back({option, 0, 0, 0});
  }
  std::vector<Fault> faults;
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t o = 0; o < options_[j].size(); ++o) {
      PricedOption& priced = options_[j][o];
      try {
        const bool stated = chosen(j);
        const Spec spec = stated ? variant_of({change(j, o)}, effects_of(j, o)) : base_;
        priced.bits = -std::log2(spec.model.transmission.encoders[j].resolution);
        priced.price = priced.option.price +
                       (priced.option.price_per_bit > 0
                            ? priced.option.price_per_bit * std::log2(spec.encoder_figures[j].counts_per_rev)
                            : 0);
        constexpr double millionths = 1e6;
        if (request.minimize == DesignRequest::Minimize::resolution)
          priced.cost = std::llround(millionths * priced.bits);
        else
          priced.cost = std::llround(millionths * priced.price);
        if (!stated) priced.cost = 0;
      } catch (const Error& e) {
        if (e.trouble() != Trouble::input) throw;
        for (Fault fault : e.faults()) {
          if (!priced.option.name.empty()) fault.rule += " (option " + quoted(priced.option.name) + ")";
          faults.push_back(fault);
        }
      }
    }
    std::stable_sort(options_[j].begin(), options_[j].end(),
                     [](const PricedOption& a, const PricedOption& b) { return a.cost < b.cost; });
  }
  if (!faults.empty()) throw Error(faults);
}

SpecChange DesignProblem::change(std::size_t joint, std::size_t option) const {
  return {"encoders." + base_.model.chain.independent[joint].name, options_[joint][option].option.entry};
}

std::vector<Node> DesignProblem::effects_of(std::size_t joint, std::size_t option) const {
  std::vector<Node> effects;
  for (const Node& effect : options_[joint][option].option.effects)
    effects.push_back(on_joint(effect, base_.model.chain.independent[joint].name));
  return effects;
}

std::vector<SpecChange> DesignProblem::changes(const OptionChoice& choice) const {
  std::vector<SpecChange> all;
  for (std::size_t j = 0; j < choice.size(); ++j)
    if (chosen(j)) all.push_back(change(j, choice[j]));
  return all;
}

std::vector<Node> DesignProblem::effects(const OptionChoice& choice) const {
  std::vector<Node> all;
  for (std::size_t j = 0; j < choice.size(); ++j)
    for (Node& effect : effects_of(j, choice[j])) all.push_back(std::move(effect));
  return all;
}

Spec DesignProblem::variant(const OptionChoice& choice, const std::vector<NamedFilter>& filters) const {
  Spec spec = variant_of(changes(choice), effects(choice));
  spec.filters = filters;
  return spec;
}

std::vector<RequirementResult> DesignProblem::results(const OptionChoice& choice,
                                                      const std::vector<NamedFilter>& filters) const {
  return evaluate(variant(choice, filters), workspace_).results;
}

void DesignProblem::make_columns() {
  std::vector<ErrorSource> sources;
  for (std::size_t j = 0; j < options_.size(); ++j)
    for (std::size_t o = 0; o < options_[j].size(); ++o) {
      if (!chosen(j) && j > 0) continue;
      const Spec spec = chosen(j) ? variant_of({change(j, o)}, effects_of(j, o)) : base_;
      EffectReport report = effect_report(spec);
      require_known(spec, report.shares);
      for (ErrorSource& source : report.sources) {
        source.mean = source.half_width = source.sigma = 0;
        source.sigma_ratios.clear();
        const bool known = std::any_of(sources.begin(), sources.end(), [&](const ErrorSource& other) {
          return other.where == source.where && other.owner == source.owner && other.link == source.link &&
                 other.direction == source.direction;
        });
        if (!known) sources.push_back(std::move(source));
      }
    }
  const auto count = static_cast<double>(size(base_.configurations));
  const double numbers = count * 3 * static_cast<double>(base_.model.coordinates.size()) *
                         static_cast<double>(options_.size() + sources.size());
  if (numbers > most_numbers)
    throw Error(Fault{{base_.file, 1, 1},
                      "configurations.count",
                      "a choice of encoders keeps the Jacobians of all configurations in memory",
                      significant(8e-9 * numbers, 3) + " GB",
                      "choose fewer, such as 100000"});
  columns_ = std::make_unique<ErrorColumns>(base_.model, sources, base_.configurations, workspace_.threads);
}

void DesignProblem::weigh(const std::vector<NamedFilter>& filters) {
  std::vector<Norms> norms;
  for (const NamedFilter& f : filters) norms.push_back(f.norms);
  weights_.assign(options_.size(), {});
  biased_ = false;
  for (std::size_t j = 0; j < options_.size(); ++j)
    for (std::size_t o = 0; o < options_[j].size(); ++o) {
      Spec spec = chosen(j) ? variant_of({change(j, o)}, effects_of(j, o)) : base_;
      spec.filters = filters;
      std::vector<Eigen::VectorXd> noise;
      if (needs_motion_noise_) noise = noise_in_motion(spec, workspace_.threads);
      add_effects(effect_report(spec), spec);
      weights_[j].push_back(error_weights(*columns_, spec.model, norms, noise));
      biased_ = biased_ || weights_[j].back().biased();
    }
  find_owners();
}

/// The joint whose options change a column; any joint where none does.
void DesignProblem::find_owners() {
  const auto vary = [](const ErrorWeights& a, const ErrorWeights& b, Eigen::Index k) {
    return a.half_width[k] != b.half_width[k] || a.mean[k] != b.mean[k] || a.variance[k] != b.variance[k];
  };
  owners_.assign(columns_->columns(), 0);
  std::vector<bool> owned(columns_->columns());
  for (std::size_t j = 0; j < options_.size(); ++j)
    for (const ErrorWeights& w : weights_[j]) {
      const ErrorWeights& first = weights_[j].front();
      bool along_motion = w.added_worst != first.added_worst || w.added_variance != first.added_variance;
      for (std::size_t f = 0; f < w.filtered.size(); ++f)
        along_motion = along_motion || w.filtered[f].added_worst != first.filtered[f].added_worst;
      const std::string& name = base_.model.chain.independent[j].name;
      if (along_motion)
        throw Error(Fault{{base_.file, 1, 1},
                          "effects",
                          "along a motion an effect of joint " + quoted(name) +
                              " depends on its encoder: such errors of several joints do not add",
                          "",
                          "remove `motion:`, or choose no encoder for that joint"});
      for (std::size_t k = 0; k < owners_.size(); ++k) {
        if (!vary(w, first, static_cast<Eigen::Index>(k))) continue;
        if (owned[k] && owners_[k] != j)
          throw Error(Fault{{base_.file, 1, 1},
                            "effects",
                            "the options of joint " + quoted(name) + " change the errors of another one",
                            "",
                            "choose no encoder for one of them"});
        owned[k] = true;
        owners_[k] = j;
      }
    }
}

const double* DesignProblem::part(std::size_t coordinate, std::size_t column, Part kind) {
  const double* const from = columns_->column(coordinate, column);
  AlignedNumbers& to = parts_[{coordinate, column, kind}];
  if (to.size() > 0) return to.data();
  const std::size_t n = columns_->configurations();
  to = AlignedNumbers(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double a = std::clamp(from[i], -beyond_all, beyond_all);
    to[i] = kind == Part::magnitude  ? std::abs(a)
            : kind == Part::positive ? std::max(a, 0.0)
            : kind == Part::negative ? std::max(-a, 0.0)
                                     : std::min(a * a, beyond_all);
  }
  return to.data();
}

const double* DesignProblem::squares_of_length(std::size_t first, std::size_t column) {
  AlignedNumbers& to = parts_[{base_.model.coordinates.size() + first, column, Part::square}];
  if (to.size() > 0) return to.data();
  to = AlignedNumbers(columns_->configurations());
  for (std::size_t c = 0; c < 3; ++c) {
    const Coordinate component = static_cast<Coordinate>(first + c);
    const auto& all = base_.model.coordinates;
    const auto at = static_cast<std::size_t>(std::find(all.begin(), all.end(), component) - all.begin());
    const double* const squares = part(at, column, Part::square);
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += squares[i];
  }
  return to.data();
}

template <class Weight>
void DesignProblem::add_column(WeightedSum& sum, std::size_t column, const double* coefficients,
                               Weight weight) {
  const std::size_t j = owners_[column];
  WeightedColumn added{j, coefficients, {}};
  // The owner's options; all other joints leave the column as it is in the spec.
  for (const ErrorWeights& w : weights_[j])
    added.weights.push_back(weight(w, static_cast<Eigen::Index>(column)));
  if (std::any_of(added.weights.begin(), added.weights.end(), [](double w) { return w != 0; }))
    sum.columns.push_back(std::move(added));
}

WeightedSum DesignProblem::sigma_sum(const Requirement& r) {
  const auto& coordinates = base_.model.coordinates;
  const bool length = r.coordinate >= coordinates.size();
  const Coordinate c = coordinates_and_lengths(base_.model)[r.coordinate];
  const auto first = length ? static_cast<std::size_t>(first_component(c)) : 0;
  const auto f = static_cast<std::size_t>(std::max<std::ptrdiff_t>(r.filter, 0));
  const bool in_motion = r.bound == Requirement::Bound::sigma_in_motion;
  WeightedSum sum;
  const ErrorWeights& any = weights_.front().front();
  const Eigen::VectorXd& added = r.filter < 0 ? any.added_variance : any.filtered[f].added_variance;
  if (length) {
    for (std::size_t k = 0; k < 3; ++k)
      sum.added +=
          added[std::find(coordinates.begin(), coordinates.end(), static_cast<Coordinate>(first + k)) -
                coordinates.begin()];
  } else {
    sum.added = added[static_cast<Eigen::Index>(r.coordinate)];
  }
  for (std::size_t k = 0; k < columns_->columns(); ++k)
    add_column(sum, k, length ? squares_of_length(first, k) : part(r.coordinate, k, Part::square),
               [&](const ErrorWeights& w, Eigen::Index column) {
                 return r.filter < 0 ? w.variance[column]
                        : in_motion  ? w.filtered[f].variance_in_motion[column]
                                     : w.filtered[f].variance[column];
               });
  return sum;
}

/// The worst case of a coordinate: |A| h, or the larger of two sums where errors have a mean (ChoiceFigure).
std::vector<WeightedSum> DesignProblem::worst_sums(const Requirement& r, std::size_t coordinate) {
  const auto f = static_cast<std::size_t>(std::max<std::ptrdiff_t>(r.filter, 0));
  const auto of = [&](const ErrorWeights& w, Eigen::Index k, double sign) {
    return r.filter < 0 ? w.half_width[k] + sign * w.mean[k]
                        : w.filtered[f].l1 * w.half_width[k] + sign * w.filtered[f].dc_gain * w.mean[k];
  };
  const ErrorWeights& any = weights_.front().front();
  std::vector<WeightedSum> sums(biased_ ? 2 : 1);
  for (std::size_t s = 0; s < sums.size(); ++s) {
    sums[s].added =
        (r.filter < 0 ? any.added_worst : any.filtered[f].added_worst)[static_cast<Eigen::Index>(coordinate)];
    const double sign = s == 0 ? 1 : -1;
    for (std::size_t k = 0; k < columns_->columns(); ++k) {
      const auto& owner = weights_[owners_[k]];
      const bool symmetric = std::all_of(owner.begin(), owner.end(), [&](const ErrorWeights& w) {
        return w.mean[static_cast<Eigen::Index>(k)] == 0;
      });
      if (symmetric) {
        add_column(sums[s], k, part(coordinate, k, Part::magnitude),
                   [&](const ErrorWeights& w, Eigen::Index column) { return of(w, column, 0); });
        continue;
      }
      add_column(sums[s], k, part(coordinate, k, Part::positive),
                 [&](const ErrorWeights& w, Eigen::Index column) { return of(w, column, sign); });
      add_column(sums[s], k, part(coordinate, k, Part::negative),
                 [&](const ErrorWeights& w, Eigen::Index column) { return of(w, column, -sign); });
    }
  }
  return sums;
}

ChoiceFigure DesignProblem::figure(const Requirement& r) {
  ChoiceFigure figure;
  if (r.figure) return figure;
  figure.over = over_of(r);
  figure.percentile = std::max(0.0, percentile_of(r));
  // Beyond the limit of exact percentiles those of a report are counted in bins, right to 1e-3.
  if (figure.over == ChoiceFigure::Over::percentile && columns_->configurations() > exact_percentiles_limit)
    figure.tolerance = 2e-3;
  using Bound = Requirement::Bound;
  if (r.bound == Bound::sigma || r.bound == Bound::sigma_in_motion) {
    figure.root = true;
    figure.sums = {sigma_sum(r)};
    return figure;
  }
  const auto& coordinates = base_.model.coordinates;
  figure.bound = r.bound == Bound::worst_case_rigorous || r.coordinate >= coordinates.size();
  if (r.coordinate < coordinates.size()) {
    figure.sums = worst_sums(r, r.coordinate);
    return figure;
  }
  // A length is at least each of its components.
  const auto first =
      static_cast<std::size_t>(first_component(coordinates_and_lengths(base_.model)[r.coordinate]));
  for (std::size_t c = 0; c < 3; ++c) {
    const auto at = std::find(coordinates.begin(), coordinates.end(), static_cast<Coordinate>(first + c));
    for (WeightedSum& sum : worst_sums(r, static_cast<std::size_t>(at - coordinates.begin())))
      figure.sums.push_back(std::move(sum));
  }
  return figure;
}

ChoiceProblem DesignProblem::problem(const std::vector<NamedFilter>& filters) {
  weigh(filters);
  ChoiceProblem problem;
  problem.configurations = columns_->configurations();
  for (const auto& options : options_) {
    auto& prices = problem.prices.emplace_back();
    for (const PricedOption& option : options) prices.push_back(option.cost);
  }
  for (const Requirement& r : base_.requirements) problem.figures.push_back(figure(r));
  problem.judge = [this, filters](const OptionChoice& choice, const std::vector<double>& limits) {
    const std::vector<RequirementResult> all = results(choice, filters);
    ChoiceProblem::Verdict verdict{true, {}};
    for (std::size_t i = 0; i < all.size(); ++i)
      if (!base_.requirements[i].figure && !(all[i].value <= limits[i])) verdict.met = false;
    return verdict;
  };
  return problem;
}

}  // namespace qerr
