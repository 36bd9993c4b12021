#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "core/text.hpp"
#include "input/design_request.hpp"
#include "input/read_sections.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figures.hpp"
#include "report/design/design_solver.hpp"

namespace qerr {

namespace {

/// Numbers that the columns of a search may take: 4 GB.
constexpr double most_numbers = 5e8;
/// Variants that are kept, of some 50 kB each; more are read again for each set of filters.
constexpr std::size_t most_kept = 4096;

Node with_requirements(const SpecVariants& variants, const std::vector<Node>& more) {
  const Spec& base = variants.base();
  Node root = parse_yaml(base.text, base.file);
  apply_changes(root, spec_changes(base.overrides),
                [&](const Node&) -> const Chain& { return base.model.chain; });
  Node list{Node::Type::sequence, more.front().place, {}, false, {}, {}};
  if (const Node* stated = root.find("requirements"); stated && stated->type == Node::Type::sequence)
    list = *stated;
  list.items.insert(list.items.end(), more.begin(), more.end());
  return list;
}

void set_figures(PricedOption& o, const Spec& spec, std::size_t joint) {
  const double whole = spec.model.chain.independent[joint].prismatic() ? 1 : 2 * std::numbers::pi;
  o.bits = std::log2(whole / spec.model.transmission.encoders[joint].resolution);
  if (o.price && o.option.price_per_bit > 0)
    *o.price += o.option.price_per_bit * std::log2(spec.encoder_figures[joint].counts_per_rev);
}

/// A fault of an option; of a row that several joints may have, once.
void add_fault(Fault fault, const std::string& option, std::vector<Fault>& to) {
  fault.rule += " (option " + quoted(option) + ")";
  if (std::ranges::none_of(to, [&](const Fault& known) {
        return known.place.line == fault.place.line && known.place.file == fault.place.file &&
               known.rule == fault.rule;
      }))
    to.push_back(std::move(fault));
}

}  // namespace

Spec FilterSet::applied(Spec spec) const {
  spec.filters = filters;
  if (control) spec.model.control = control;
  return spec;
}

DesignProblem::DesignProblem(const SpecVariants& variants, const DesignRequest& request,
                             const std::vector<Node>& more, const WorkspaceOptions& workspace)
    : variants_(variants), workspace_(workspace) {
  if (!more.empty()) common_.emplace_back("requirements", with_requirements(variants, more));
  base_ = variant_of({}, {});
  for (const Requirement& r : base_.requirements) {
    if (r.of_control) require_limit_of_control(r, base_);
    if (!r.limits_error()) continue;
    needs_motion_noise_ = needs_motion_noise_ || r.bound == Bound::sigma_in_motion;
    any_proven_ = any_proven_ || r.statistic == "proven_max";
    needs_rigorous_ = needs_rigorous_ || r.bound == Bound::worst_case_rigorous;
    if (r.at_least)
      throw requirement_error(r, "at_least of an error is no limit of a design: finer encoders only lower it",
                              "write at_most, or leave it to `qerr check`", r.name());
  }
  refuse_unreached(analysis_of_some(base_, workspace_.threads));  // whatever the encoders
  workspace_.brief = !needs_rigorous_;
  read_options(request);
  if (obstacles_.empty()) make_columns();
}

Spec DesignProblem::variant_of(const std::vector<SpecChange>& changes,
                               const std::vector<Node>& effects) const {
  std::vector<SpecChange> all = common_;
  all.insert(all.end(), changes.begin(), changes.end());
  return variants_.variant(all, effects);
}

/// Reads the options of one joint, without those that cannot count fast enough.
void DesignProblem::read_joint(const JointOptions& joint, bool kept, std::vector<Fault>& faults) {
  std::vector<PricedOption>& options = options_[joint.joint];
  std::vector<std::pair<std::string, std::string>> slow;  // name, why
  options.clear();
  for (const EncoderOption& option : joint.options) {
    options.push_back({option, nullptr, option.price, 0, 0});
    const std::size_t o = options.size() - 1;
    try {
      const auto variant =
          std::make_shared<const Spec>(variant_of({change(joint.joint, o)}, effects_of(joint.joint, o)));
      if (kept) options.back().variant = variant;
      add_slow_errors(variant, joint.joint);
      set_figures(options.back(), *variant, joint.joint);
      const std::string why = too_fast(*variant, joint.joint);
      if (!why.empty()) slow.emplace_back(option.name, why);
      if (!why.empty()) options.pop_back();
    } catch (const Error& e) {
      if (e.trouble() != Trouble::input) throw;
      for (const Fault& fault : e.faults()) add_fault(fault, option.name, faults);
    }
  }
  for (const PricedOption& o : options) by_bits_ = by_bits_ || !o.price;
  leave_out(joint.joint, slow);
}

void DesignProblem::read_options(const DesignRequest& request) {
  const std::size_t n = base_.model.chain.independent.size();
  options_.assign(n, {PricedOption{}});
  for (std::size_t j = 0; j < n; ++j) add_slow_errors(std::make_shared<const Spec>(base_), j);
  speeds_ = encoder_speeds(base_);
  by_bits_ = request.minimize == DesignRequest::Minimize::resolution;
  std::size_t all = 0;
  for (const JointOptions& joint : request.encoders) all += joint.options.size();
  std::vector<Fault> faults;
  for (const JointOptions& joint : request.encoders) read_joint(joint, all <= most_kept, faults);
  if (!faults.empty()) throw Error(faults);
  constexpr double millionths = 1e6;
  for (auto& options : options_) {
    for (PricedOption& o : options)
      if (!o.option.name.empty()) o.cost = std::llround(millionths * (by_bits_ ? o.bits : *o.price));
    std::ranges::stable_sort(options,
                             [](const PricedOption& a, const PricedOption& b) { return a.cost < b.cost; });
  }
}

/// Why the encoder of a variant cannot follow its joint; "" if it can, or the speed is not known.
std::string DesignProblem::too_fast(const Spec& spec, std::size_t joint) const {
  const std::optional<double>& speed = speeds_[joint];
  if (!speed) return "";
  const std::optional<CountLimit> limit = count_limit(spec, joint);
  if (limit && count_rate(spec, joint, *speed) > limit->rate) return count_rate_text(spec, joint, *speed);
  for (const Requirement& r : base_.requirements)
    if (r.counter == static_cast<std::ptrdiff_t>(joint) && !r.met_by(count_rate(spec, joint, *speed)))
      return significant(count_rate(spec, joint, *speed), 4) + " counts/s, " +
             (r.at_least ? "at least " : "at most ") + significant(r.limit, 4) + " are required";
  return "";
}

void DesignProblem::leave_out(std::size_t joint,
                              const std::vector<std::pair<std::string, std::string>>& options) {
  if (options.empty()) return;
  constexpr std::size_t most_named = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(options.size(), most_named); ++i)
    text += (i ? "; " : "") + quoted(options[i].first) + ' ' + options[i].second;
  if (options.size() > most_named) text += "; " + std::to_string(options.size() - most_named) + " more";
  const bool none = options_[joint].empty();
  const std::string all = counted(options.size() + options_[joint].size(), "option");
  (none ? obstacles_ : left_out_)
      .push_back(
          "joint " + qerr::quoted(base_.model.chain.independent[joint].name) + ": " +
          (none ? "none of " + all : std::to_string(options.size()) + " of " + all + " are left out, which") +
          (none ? " can count at the rate: " : " cannot count at the rate: ") + text);
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

Spec DesignProblem::variant(const OptionChoice& choice, const FilterSet& set) const {
  return set.applied(variant_of(changes(choice), effects(choice)));
}

std::vector<RequirementResult> DesignProblem::results(const OptionChoice& choice, const FilterSet& set,
                                                      const std::vector<double>* limits) const {
  if (limits && !any_proven_ && set.evaluated) {  // values are those of any limits; proofs depend on them
    auto known = set.evaluated->find(choice);
    if (known == set.evaluated->end()) known = set.evaluated->emplace(choice, results(choice, set)).first;
    std::vector<RequirementResult> all = known->second;
    for (std::size_t i = 0; i < all.size(); ++i) {
      Requirement r = base_.requirements[i];
      if (!r.limits_error()) continue;
      r.limit = (*limits)[i];
      all[i].met = r.met_by(all[i].value);
    }
    return all;
  }
  Spec spec = variant(choice, set);
  for (std::size_t i = 0; limits && i < spec.requirements.size(); ++i)
    if (spec.requirements[i].limits_error()) spec.requirements[i].limit = (*limits)[i];
  if (any_proven_) return evaluate(spec, workspace_, {.of_distance = limits ? 1.0 : 0.0}).results;
  // Without the warnings of `analyze`, which take longer than the figures.
  WorkspaceOptions options = workspace_;
  if (needs_motion_noise_) options.noise_in_motion = noise_in_motion(spec, options.threads);
  add_effects(effect_report(spec), spec);
  const std::vector<Norms> norms = filter_norms(spec);
  const Workspace sampled = workspace_with_quantization(spec.model, norms, spec.configurations, options);
  const ControlReport control = any_of_control(spec) ? control_report(spec, true) : ControlReport{};
  std::vector<RequirementResult> all;
  for (const Requirement& r : spec.requirements)
    all.push_back(r.of_control     ? evaluate(r, control_value(r, spec, control))
                  : r.counter >= 0 ? evaluate(r, required_count_rate(r, spec, speeds_))
                                   : evaluate(r, sampled, designed_filters(spec), norms));
  return all;
}

void DesignProblem::make_columns() {
  const auto add_places = [&](const Spec& spec) {
    EffectReport report = effect_report(spec);
    require_known(spec, report.shares);
    for (IndependentError& source : report.sources) {
      source.mean = source.half_width = source.sigma = 0;
      source.sigma_ratios.clear();
      source.loop_ratios.clear();
      const bool known = std::ranges::any_of(sources_, [&](const IndependentError& other) {
        return other.where == source.where && other.owner == source.owner && other.link == source.link &&
               other.direction == source.direction;
      });
      if (!known) sources_.push_back(std::move(source));
    }
  };
  add_places(base_);
  for (std::size_t j = 0; j < options_.size(); ++j)
    for (std::size_t o = 0; o < options_[j].size(); ++o)
      if (chosen(j)) add_places(variant_by(j, o));
  const auto count = static_cast<double>(size(base_.configurations));
  const double numbers = count * 3 * static_cast<double>(base_.model.coordinates.size()) *
                         static_cast<double>(options_.size() + sources_.size());
  if (numbers > most_numbers)
    throw spec_error(base_, "configurations.count",
                     "a choice of encoders keeps the Jacobians of all configurations in memory",
                     significant(8e-9 * numbers, 3) + " GB", "choose fewer, such as 100000");
  columns_ = std::make_unique<ErrorColumns>(base_.model, sources_, base_.configurations, workspace_.threads);
  sums_ = std::make_unique<FigureSums>(base_, *columns_);
}

void DesignProblem::add_slow_errors(std::shared_ptr<const Spec> variant, std::size_t joint) {
  const Spec& spec = *variant;
  const auto kind = [joint](const Spec& s) {
    const Encoder& e = s.model.transmission.encoders[joint];
    std::string effects;
    for (const Effect& effect : s.effects)
      if (independent_index(s.model.chain, effect.joint) == joint) effects += effect.type + ',';
    return std::tuple(e.shaft_ratio, e.accuracy > 0, e.gear_accuracy > 0, effects);
  };
  const auto& [ratio, accuracy, of_gear, effects] = kind(spec);
  if (!accuracy && !of_gear && effects.empty()) return;
  for (const auto& [other, of_joint] : slow_)
    if (of_joint == joint && kind(*other) == kind(spec)) return;
  slow_.emplace_back(std::move(variant), joint);
}

Spec DesignProblem::variant_by(std::size_t j, std::size_t o) const {
  return options_[j][o].variant ? *options_[j][o].variant : variant_of({change(j, o)}, effects_of(j, o));
}

OptionWeights DesignProblem::weights_with(const std::vector<NamedFilter>& filters) const {
  std::vector<Norms> norms;
  for (const NamedFilter& f : filters) norms.push_back(f.norms);
  const auto weigh = [&](Spec spec) {
    spec.filters = filters;
    std::vector<Eigen::VectorXd> noise;
    if (needs_motion_noise_) noise = noise_in_motion(spec, workspace_.threads);
    add_effects(effect_report(spec), spec);
    return error_weights(*columns_, spec.model, norms, noise);
  };
  OptionWeights weights{weigh(base_), {}, {}, false};
  for (std::size_t j = 0; j < options_.size(); ++j) {
    auto& of_joint = weights.options.emplace_back();
    for (std::size_t o = 0; o < options_[j].size(); ++o)
      of_joint.push_back(chosen(j) ? weigh(variant_by(j, o)) : weights.stated);
  }
  find_owners(weights, base_);
  return weights;
}

/// At the configuration where a figure is largest with a choice, its value with any choice.
ChoiceCut DesignProblem::cut_at(const Eigen::VectorXd& q, std::size_t figure, const OptionWeights& weights,
                                const OptionChoice& choice, const ChoiceProblem& shape) const {
  Configurations one = base_.configurations;
  one.method = SamplingMethod::list;
  one.points = {q};
  const ErrorColumns columns(base_.model, sources_, one, 1);
  FigureSums sums(base_, columns);
  const ChoiceFigure there = sums.figure(base_.requirements[figure], weights, choice);
  return cut_at_configuration(there, figure, shape, weights_of(there, choice), 0);
}

bool DesignProblem::of_loops(const Requirement& r) const {
  return r.of_control || (r.limits_error() && is_closed(all_signals(base_.model)[r.signal]));
}

/// The sums of loops and walls with a set of filters, which the figures of its problem borrow; null where no
/// requirement needs them.
ControlSums* DesignProblem::control_sums(const FilterSet& set) {
  const auto figures =
      std::ranges::count_if(base_.requirements, [&](const Requirement& r) { return of_loops(r); });
  if (figures == 0) return nullptr;
  kept_numbers_ +=
      static_cast<double>(figures) * static_cast<double>(columns_->configurations() * options_.size());
  if (kept_numbers_ > most_numbers)
    throw spec_error(
        base_, "configurations.count",
        "a choice for loops keeps norms at all configurations in memory, for each set of filters",
        "more than 4 GB", "choose fewer configurations, such as 1000, or fewer filters");
  std::vector<std::vector<double>> resolutions;
  for (std::size_t j = 0; j < options_.size(); ++j) {
    auto& of_joint = resolutions.emplace_back();
    for (std::size_t o = 0; o < options_[j].size(); ++o)
      of_joint.push_back((chosen(j) ? variant_by(j, o) : base_).model.transmission.encoders[j].resolution);
  }
  return control_
      .emplace_back(std::make_unique<ControlSums>(set.applied(base_), columns_->configurations(),
                                                  std::move(resolutions)))
      .get();
}

ChoiceProblem DesignProblem::problem(const FilterSet& set) {
  const auto weights = std::make_shared<const OptionWeights>(weights_with(set.filters));
  ChoiceProblem problem;
  problem.configurations = columns_->configurations();
  OptionChoice middle;
  for (const auto& options : options_) {
    auto& prices = problem.prices.emplace_back();
    for (const PricedOption& option : options) prices.push_back(option.cost);
    middle.push_back(options.size() / 2);
  }
  const ChoiceProblem shape{problem.prices, 1, {}, {}};
  ControlSums* const control = control_sums(set);
  for (const Requirement& r : base_.requirements)
    problem.figures.push_back(of_loops(r) ? control->figure(r, *weights)
                                          : sums_->figure(r, *weights, middle));
  problem.judge = [this, set, weights, shape](const OptionChoice& choice, const std::vector<double>& limits) {
    const std::vector<RequirementResult> all = results(choice, set, &limits);
    // A proof takes some tenths of a second: fewer multiply-adds, so that a search has some hundreds of them.
    constexpr double work_of_proof = 5e7;
    const double sampled = 10 * static_cast<double>(columns_->configurations() * choice.size());
    ChoiceProblem::Verdict verdict{true, {}, sampled + (any_proven_ ? work_of_proof : 0)};
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Requirement& r = base_.requirements[i];
      if (!r.limits_error() || all[i].met) continue;
      verdict.met = false;
      const bool largest = r.statistic == "max" || r.statistic == "proven_max";
      if (largest && all[i].at_max.size() > 0)
        verdict.cuts.push_back(cut_at(all[i].at_max, i, *weights, choice, shape));
    }
    return verdict;
  };
  return problem;
}

}  // namespace qerr
