#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "bound/batched_error.hpp"
#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "qerr/report/write.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

double largest(const Workspace& w, std::ptrdiff_t filter, std::size_t coordinate) {
  if (filter < 0) return w.coordinates[coordinate].worst_case.max;
  const DerivativeStatistics& d = w.derivatives[filter][coordinate];
  return d.worst_case.max;
}

/// The worst case of the coordinate if every joint moved it with the whole reach as its lever arm.
double conceivable(const Analysis& a, std::ptrdiff_t filter, const Signal& signal) {
  const bool length = signal.unit == "m";
  const double arm = length ? reach(a.spec.model.chain, a.spec.configurations) : 1;
  double sum = 0;
  for (std::size_t i = 0; i < a.spec.model.chain.independent.size(); ++i) {
    const bool prismatic = a.spec.model.chain.independent[i].prismatic();
    sum += (prismatic ? (length ? 1 : 0) : arm) * a.joints.worst_case[i];
  }
  return filter < 0 ? sum : sum * a.spec.filters[filter].norms.h2;
}

/// Whether a quantity is a share at the most of what is conceivable.
bool is_below(const Analysis& a, std::ptrdiff_t filter, std::size_t signal, double share) {
  return largest(a.workspace, filter, signal) <=
         share * conceivable(a, filter, all_signals(a.spec.model)[signal]);
}

bool is_unreached(const Analysis& a, std::ptrdiff_t filter, std::size_t signal) {
  // Entries of the Jacobian that vanish are rounding errors of some 1e-16 times the reach. No two encoders of
  // a robot differ by 1e13 in resolution.
  return is_below(a, filter, signal, 1e-13);
}

/// Angles between joints that are this near to right angles, or to none [rad]: pi/2 and pi with four decimals
/// or more, some of them in a row; and with two decimals. A tilt of the first size is nowhere measured, one
/// of the second may be.
constexpr double rounded_angle = 5e-5, almost_right_angle = 2e-3;

/// A rotation whose entries below the tolerance are zeros.
Eigen::Matrix3d without_rounding(Eigen::Matrix3d rotation, double tolerance) {
  rotation = (rotation.array().abs() < tolerance).select(0.0, rotation);
  const Eigen::Vector3d x = rotation.col(0).normalized(),
                        y = (rotation.col(1) - x * x.dot(rotation.col(1))).normalized();
  return (Eigen::Matrix3d() << x, y, x.cross(y)).finished();
}

Chain without_rounding(Chain chain, double tolerance) {
  for (ChainJoint& j : chain.joints) {
    j.origin.linear() = without_rounding(j.origin.linear(), tolerance);
    j.axis = (j.axis.array().abs() < tolerance).select(0.0, j.axis).normalized();
  }
  chain.tip_offset.linear() = without_rounding(chain.tip_offset.linear(), tolerance);
  return chain;
}

/// Whether no error reaches the quantity where angles that are nearly right are right.
bool moved_by_rounding(const Analysis& a, const Requirement& r, double tolerance) {
  const double angles = static_cast<double>(a.spec.model.chain.joints.size() + 1);
  if (!is_below(a, r.filter, r.signal, angles * tolerance)) return false;
  Spec right = a.spec;
  right.requirements.clear();
  right.model.chain = without_rounding(a.spec.model.chain, tolerance);
  return is_unreached(analysis_of_some(right, 1), r.filter, r.signal);
}

/// What to require in place of a quantity that no error reaches.
std::string reached_instead(const Analysis& a) {
  const double least = static_cast<double>(a.spec.model.chain.joints.size() + 1) * rounded_angle;
  std::vector<std::string> names;
  const std::vector<Signal> all = all_signals(a.spec.model);
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!is_below(a, -1, i, least)) names.push_back(all[i].name);
  return names.empty() ? "the joints move none of the spec's coordinates; add those that they move, such as "
                         "rx, ry, rz, to `coordinates`"
                       : "the joints move " + joined(names);
}

/// Changes of these are changes, also where the figures of some configurations do not show them.
std::string extent_of(const Spec& spec) {
  std::string text = std::to_string(size(spec.configurations));
  if (spec.motion)
    text += ' ' + shortest(spec.motion->duration) + ' ' + shortest(spec.motion->settling.value_or(-1));
  return text;
}

/// A limit with three digits, or with all that it has, so that two limits differ where they are named. A
/// number with a unit, such as 0.7 mm, is read to 15 digits.
std::string limit_text(const Requirement& r) {
  constexpr int digits = 15;
  const double limit = rounded_to(r.limit, digits);
  if (!std::isfinite(limit) || rounded_to(limit, 3) == limit) return readable(limit, r.unit);
  const PrefixedUnit prefix = prefixed(limit, r.unit);
  return shortest(rounded_to(limit / prefix.factor, digits)) + (r.unit.empty() ? "" : ' ' + prefix.unit);
}

}  // namespace

Analysis analysis_of_some(const Spec& spec, unsigned threads) {
  constexpr std::uint64_t some = 256, most_points = 100'000;
  Spec brief = spec;
  Configurations& c = brief.configurations;
  const double joints = static_cast<double>(c.ranges.size());
  if (c.method == SamplingMethod::list)
    c.points.resize(std::min<std::size_t>(c.points.size(), most_points));
  else
    c.count = std::min(
        c.count, c.method == SamplingMethod::grid
                     ? std::max(std::uint64_t{1}, static_cast<std::uint64_t>(std::pow(some, 1 / joints)))
                     : some);
  for (Requirement& r : brief.requirements)
    if (r.proven) {  // a proof takes longer than a question that does not depend on it
      r.proven = false;
      r.value = &Statistic::max;
    }
  WorkspaceOptions options;
  options.threads = threads;
  return analyze(brief, options);
}

std::string verdicts_of_some(const Spec& spec, unsigned threads) {
  const Analysis a = analysis_of_some(spec, threads);
  const std::vector<RequirementResult> results = requirement_results(a);
  std::string text;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Requirement& r = spec.requirements[i];
    text += r.name() + ' ' + std::string(r.relation()) + ' ' + shortest(r.limit) + ": " +
            shortest(results[i].value) + '\n';
  }
  return text + extent_of(spec);
}

std::string figures_of_some(const Spec& spec, unsigned threads, const std::string& format) {
  std::string text = write(analysis_of_some(spec, threads), format) + extent_of(spec);
  for (const NamedFilter& f : spec.filters)
    for (const FilterFigure& figure : filter_figures())
      text += shortest(figure.value(f.filter, f.norms).value_or(0)) + ' ';
  for (const Requirement& r : spec.requirements)
    text += '\n' + r.name() + ' ' + std::string(r.relation()) + ' ' + shortest(r.limit);
  return text;
}

std::optional<std::vector<RequirementResult>> verdicts_beside(const Spec& spec) {
  constexpr std::uint64_t quick = 1'000'000;  // configurations
  const bool proofs = std::ranges::any_of(spec.requirements, &Requirement::proven);
  if (spec.requirements.empty() || proofs || size(spec.configurations) > quick) return std::nullopt;
  try {
    auto results = evaluate(spec).results;
    for (RequirementResult& r : results) r.at_max.resize(0);  // of another page
    return results;
  } catch (const Error&) {
    return std::nullopt;
  }
}

void refuse_unreached(const Analysis& a, const std::vector<Requirement>& limits, const std::string& key) {
  std::vector<Fault> faults;
  for (const Requirement& r : limits) {
    if (!r.limits_error()) continue;
    const Statistic* const in_motion =
        r.bound == Bound::sigma_in_motion ? statistic_of(a.workspace, r) : nullptr;
    const bool at_rest = in_motion && !r.proven && in_motion->max == 0;
    const bool unreached = is_unreached(a, r.filter, r.signal);
    if (!at_rest && !unreached && !moved_by_rounding(a, r, rounded_angle)) continue;
    faults.push_back({r.place, key,
                      at_rest || unreached
                          ? "no error reaches this quantity: it is 0 at all configurations, which meets any "
                            "limit"
                          : "only the rounding of the URDF's angles, such as 1.5708 for pi/2, lets an error "
                            "reach this quantity: " +
                                readable(largest(a.workspace, r.filter, r.signal), r.unit) +
                                " at the most, which meets any limit",
                      quoted(r.quantity),
                      at_rest ? "along `motion:` no encoder counts; require sigma, or let the joints move"
                              : reached_instead(a)});
  }
  if (!faults.empty()) throw Error(faults);
}

void refuse_unreached(const Analysis& a) {
  refuse_unreached(a, a.spec.requirements, "requirements");
  refuse_changed_loops(a.spec);
}

std::vector<RequirementResult> requirement_results(const Analysis& a) {
  refuse_unreached(a);
  const std::vector<Filter> filters = designed_filters(a.spec);
  const std::vector<Norms> norms = filter_norms(a.spec);
  std::vector<RequirementResult> results;
  const auto counts = [](const Requirement& r) { return r.counter >= 0; };
  const EncoderSpeeds speeds =
      std::ranges::any_of(a.spec.requirements, counts) ? encoder_speeds(a.spec) : EncoderSpeeds{};
  for (const Requirement& r : a.spec.requirements) {
    results.push_back(r.of_control     ? evaluate(r, control_value(r, a.spec, *a.control))
                      : r.counter >= 0 ? evaluate(r, required_count_rate(r, a.spec, speeds))
                      : r.proven       ? evaluate(r, *find_proof(a, proven_figure(r, a.spec.model)))
                                       : evaluate(r, a.workspace, filters, norms));
    if (r.counter >= 0 && results.back().value == 0)
      throw requirement_error(r, "the encoder does not move along `motion:`, which meets any limit",
                              "let the joint move, or leave out `motion:`, for the URDF's speed");
  }
  return results;
}

SpecCheck evaluate(const Spec& spec, const WorkspaceOptions& options, const ProofRequest& proofs) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  EffectReport effects = effect_report(spec);
  require_known(spec, effects.shares);
  SpecCheck report{analyze(spec, std::move(effects), options, proofs), {}};
  report.results = requirement_results(report.analysis);
  for (const Requirement& r : spec.requirements)
    if (r.limits_error() && moved_by_rounding(report.analysis, r, almost_right_angle))
      report.analysis.warnings.push_back({"requirements: '" + r.quantity +
                                          "' is moved only by angles of the URDF that are right angles to 2 "
                                          "mrad: if they are rounded, such as "
                                          "1.57 for pi/2, the requirement says nothing; " +
                                          reached_instead(report.analysis)});
  report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return report;
}

double margin(double value, double limit, bool at_least) {
  const double distance = at_least ? value - limit : limit - value;
  return limit != 0 ? distance / std::abs(limit) : std::numeric_limits<double>::quiet_NaN();
}

double margin(const Requirement& r, const RequirementResult& result) {
  return margin(result.value, r.limit, r.at_least);
}

std::string margin_text(const Requirement& r, const RequirementResult& result) {
  const double part = margin(r, result);
  return std::isnan(part) ? "" : percent(part);
}

std::optional<double> part_of_limit(const Requirement& r, const RequirementResult& result) {
  const double part = r.at_least ? r.limit / result.value : result.value / r.limit;
  return r.limit > 0 && std::isfinite(part) && part >= 0 ? std::optional(part) : std::nullopt;
}

std::string limited(const Requirement& r) {
  return r.name() + (r.at_least ? " >= " : " <= ") + limit_text(r);
}

Error requirement_error(const Requirement& r, const std::string& rule, const std::string& remedy,
                        const std::string& name) {
  return Error(r.place, "requirements", rule, quoted(name.empty() ? r.quantity : name), remedy);
}

Error spec_error(const Spec& spec, const std::string& key, const std::string& rule, const std::string& found,
                 const std::string& remedy) {
  return Error({spec.file, 1, 1}, key, rule, found, remedy);
}

std::string relation(bool at_least, bool met) { return at_least ? (met ? ">=" : "<") : (met ? "<=" : ">"); }

std::string configuration_text(
    const Chain& chain, const Eigen::VectorXd& q,
    const std::function<std::string(const IndependentJoint&, double value)>& text) {
  std::vector<std::string> joints;
  for (const double value : q) {
    const IndependentJoint& joint = chain.independent[joints.size()];
    joints.push_back(text ? text(joint, value) : shown(joint.name) + ' ' + readable(value, joint.unit()));
  }
  return joined(joints);
}

std::string value_text(const Requirement& r, double value) {
  return r.of_control && std::isnan(value) ? "unstable" : readable(value, r.unit);
}

std::string verdict(const Requirement& r, const RequirementResult& result) {
  const std::string required =
      std::string(r.at_least ? "at least " : "at most ") + limit_text(r) + " is required";
  if (!result.proven) return r.name() + " is " + value_text(r, result.value) + ", " + required;
  return r.name() + " lies between " + readable(result.proven->lower, r.unit) + ", which is reached, and " +
         readable(result.proven->upper, r.unit) + ", " + required +
         (result.undecided ? ": not proven; " : "") + (result.undecided ? std::string(undecided_remedy) : "");
}

ExceedanceCounter::ExceedanceCounter(const Spec& spec, std::vector<Requirement> limits)
    : chain_(spec.model.chain), filters_(filter_norms(spec)), limits_(std::move(limits)) {
  constexpr double most_shells = 10;  // that fit on a terminal beside the other tables
  const double farthest = reach(chain_, spec.configurations);
  step_ = farthest > 0 ? round_step(farthest / most_shells) : 1;
  Exceedance empty;
  for (double from = 0; from == 0 || from < farthest * (1 - 1e-9); from += step_)
    empty.by_distance.push_back({from, from + step_, 0, 0});
  for (const Requirement& r : limits_) {
    figures_.push_back(proven_figure(r, spec.model));
    Exceedance& e = counts_.emplace_back(empty);
    e.quantity = r.quantity;
    e.limit = r.limit;
    e.unit = r.unit;
  }
}

void ExceedanceCounter::count(const ConfigurationBatch& batch) {
  std::vector<Eigen::Vector3d> tips;
  for (std::size_t i = 0; i < batch.count; ++i)
    tips.push_back(forward_kinematics(chain_, configuration_of(batch, i, chain_)).translation());
  const std::lock_guard lock(guard_);
  for (std::size_t l = 0; l < limits_.size(); ++l) {
    const auto [figure, factor] = figure_column(figures_[l], filters_, batch.layout);
    for (std::size_t i = 0; i < batch.count; ++i)
      add(counts_[l], tips[i], factor * batch.figures[figure * batch_size + i] > limits_[l].limit);
  }
}

void ExceedanceCounter::add(Exceedance& e, const Eigen::Vector3d& tip, bool above) const {
  const auto shell = std::min(static_cast<std::size_t>(tip.norm() / step_), e.by_distance.size() - 1);
  ++e.count;
  ++e.by_distance[shell].count;
  if (!above) return;
  ++e.above;
  ++e.by_distance[shell].above;
  e.lowest = e.lowest.cwiseMin(tip);
  e.highest = e.highest.cwiseMax(tip);
}

std::vector<Exceedance> ExceedanceCounter::result(const Analysis& a) const {
  for (const Requirement& r : limits_)
    if (!statistic_of(a.workspace, r) && r.bound != Bound::sigma_quantization)
      throw Error("--above", "the bound is not known at the configurations", quoted(r.quantity),
                  "the warnings of `qerr analyze` without the option say why; name another bound",
                  Trouble::usage);
  return counts_;
}

}  // namespace qerr
