#include <cmath>

#include "qerr/effect/effect_kind.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/formats.hpp"

namespace qerr {

namespace {

using Position = In<CoordinateStatistics, Analysis>;
using FilteredTip = In<NamedFilter, Analysis>;
using Derivative = In<DerivativeStatistics, FilteredTip>;

struct ReportedStatistic : Statistic {
  const Analysis& a;
  Figure figure;
};

ReportedStatistic reported(const Position& p, const Statistic& s, Bound bound) {
  return {s, p.whole, {p.i, -1, bound}};
}
ReportedStatistic reported(const Derivative& d, const Statistic& s, Bound bound) {
  return {s, d.whole.whole, {d.i, static_cast<std::ptrdiff_t>(d.whole.i), bound}};
}

template <class Member>
auto statistic(Member member, Bound bound) {
  return [=](const auto& of) {
    const auto& s = std::invoke(member, of);
    if constexpr (std::same_as<decltype(s), const Statistic&>)
      return reported(of, s, bound);
    else
      return s ? std::optional(reported(of, *s, bound)) : std::nullopt;
  };
}

std::optional<ReportedProof> proof(const ReportedStatistic& s) {
  const ProvenMaximum* proven = find_proof(s.a, s.figure);
  return proven ? std::optional(ReportedProof{*proven, s.a.spec}) : std::nullopt;
}

Signal signal(const Position& p) { return all_signals(p.whole.spec.model)[p.i]; }
Signal signal(const Derivative& d) { return all_signals(d.whole.whole.spec.model)[d.i]; }

/// `closed_torque` of a signal of closed loops.
std::string loop_of(const Signal& s) { return is_closed(s) ? std::string(s.kind->group) : ""; }

std::string coordinate_of(const Signal& s) {
  return is_closed(s) ? s.name.substr(s.kind->group.size() + 1) : s.name;
}

std::vector<Derivative> passed(const FilteredTip& f) {
  std::vector<Derivative> all;
  for (const Derivative& d : items_of(f.whole.workspace.derivatives[f.i], f))
    if (is_filtered(*f, signal(d))) all.push_back(d);
  return all;
}

auto share(Eigen::VectorXd CoordinateStatistics::*shares) {
  return [shares](const Position& p) {
    return only_if(((*p).*shares).size() > 0, by_joint(p.whole.spec, (*p).*shares));
  };
}

struct ReportedCovariance {
  Eigen::MatrixXd mean, at_largest;
};

std::optional<ReportedCovariance> covariance_behind(const FilteredTip& f) {
  const Workspace& w = f.whole.workspace;
  const double factor = f->norms.h2 * f->norms.h2;
  if (f.i >= w.filtered.size())
    return ReportedCovariance{factor * w.mean_covariance, factor * w.covariance_at_largest};
  const auto& behind = w.filtered[f.i];
  return only_if(behind.mean_covariance.size() > 0,
                 ReportedCovariance{behind.mean_covariance, behind.covariance_at_largest});
}

std::optional<std::vector<std::pair<std::string, double>>> noise_over_ipqn(const FilteredTip& f) {
  const auto& noise = f.whole.noise_in_motion;
  if (!is_known(noise, f.i)) return {};
  return by_joint(f.whole.spec, noise[f.i] * (std::sqrt(12.0) / f->norms.h2));
}

using AnalyzedJoint = In<IndependentJoint, Analysis>;

auto encoder(double Encoder::*value) {
  return [value](const AnalyzedJoint& j) {
    const double of = j.whole.spec.model.transmission.encoders[j.i].*value;
    return only_if(of > 0, of);
  };
}

auto error(Eigen::VectorXd JointError::*value) {
  return [value](const AnalyzedJoint& j) { return (j.whole.joints.*value)[j.i]; };
}

/// Empty without a limit; else the rate, which may not be known.
std::optional<std::optional<double>> rate(const AnalyzedJoint& j) {
  if (!count_limit(j.whole.spec, j.i)) return {};
  const std::optional<double> speed = encoder_speeds(j.whole.spec)[j.i];
  return only_if(true, speed ? std::optional(count_rate(j.whole.spec, j.i, *speed)) : std::nullopt);
}

std::optional<double> most_rate(const AnalyzedJoint& j) {
  const std::optional<CountLimit> limit = count_limit(j.whole.spec, j.i);
  return limit ? std::optional(limit->rate) : std::nullopt;
}

using ReportedLoop = In<WorstLoop, Analysis>;
using ReportedWall = In<WorstWall, Analysis>;
using ReportedGain = In<GainReport, Analysis>;

std::string joint_name(const Analysis& a, std::size_t joint) {
  return a.spec.model.chain.independent[joint].name;
}

/// A figure of a stable loop.
template <class Member>
auto of_margins(Member LoopMargins::*member) {
  return [member](const ReportedLoop& l) {
    return l->stable ? std::optional<double>(l->margins.*member) : std::nullopt;
  };
}

using ReportedTorque = In<OpenTorque, Analysis>;

struct ReportedControl {
  std::vector<ReportedTorque> torques;
  std::vector<ReportedLoop> loops;
  std::vector<ReportedWall> walls;
  std::vector<ReportedGain> gains;
};

std::optional<ReportedControl> control(const Analysis& a) {
  if (!a.control) return std::nullopt;
  return ReportedControl{items_of(a.control->torques, a), items_of(a.control->loops, a),
                         items_of(a.control->walls, a), items_of(a.control->gains, a)};
}

using ReportedEffect = In<EffectShare, Analysis>;

/// Null for an effect of unknown size.
auto share(double (*figure)(const Share&)) {
  return [figure](const ReportedEffect& e) {
    return e->share ? std::optional(figure(*e->share)) : std::nullopt;
  };
}

struct EffectDetail {
  std::string name;
  Json value;
  std::string unit;
};

std::vector<EffectDetail> effect_details(const ReportedEffect& e) {
  std::vector<EffectDetail> all;
  for (const EffectParameter& p : effect_parameters(e.whole.spec, e->effect))
    all.push_back({p.name, p.value, p.unit});
  for (const auto& [name, word] : e->effect.choices) all.push_back({name, word, ""});
  return all;
}

std::vector<std::pair<std::string, BudgetParts>> parts_of_budget(const Analysis& a) {
  std::vector<std::pair<std::string, BudgetParts>> all;
  if (!states_accuracy(a.spec)) return all;
  for (const BudgetParts& parts : budget_parts(a))
    all.emplace_back(a.spec.model.chain.independent[all.size()].name, parts);
  return all;
}

}  // namespace

RowsOf<ReportedStatistic> rows(Of<ReportedStatistic>) {
  RowsOf<ReportedStatistic> all{};
  for (const StatisticKind& kind : statistic_kinds()) all = all.with({{kind.name, kind.value, kind.summary}});
  return all.with(
      {{"at_max", [](auto& s) { return by_joint(s.a.spec, s.at_max); }, "the joints where the maximum is"},
       {"proven", proof, "the maximum over the whole joint ranges; with --prove", optional}});
}

RowsOf<ReportedCovariance> rows(Of<ReportedCovariance>) {
  return {{"mean", [](auto& c) { return nested(c.mean); }, "over the configurations"},
          {"at_largest", [](auto& c) { return nested(c.at_largest); }, "where its trace is largest"}};
}

RowsOf<AnalyzedJoint> rows(Of<AnalyzedJoint>) {
  return {
      {"name", &IndependentJoint::name},
      {"unit", [](auto& j) { return j->unit(); }},
      {"resolution", [](auto& j) { return j.whole.resolutions[j.i]; }, "of the encoder, at the joint side"},
      {"worst_case", error(&JointError::worst_case), "of the joint, after the coupling"},
      {"sigma", error(&JointError::sigma)},
      {"mean", error(&JointError::mean)},
      {"accuracy", encoder(&Encoder::accuracy), "of the encoder, at the joint side", optional},
      {"gear_accuracy", encoder(&Encoder::gear_accuracy), "at the joint", optional},
      {"count_rate", rate, "counts/s; where a limit is stated", optional},
      {"max_count_rate", most_rate, "counts/s", optional},
      {"max_speed", [](auto& j) { return largest_speed(j.whole.spec, j.i); },
       "at which the counter can follow [rad/s or m/s]", optional}};
}

RowsOf<Position> rows(Of<Position>) {
  using Statistics = CoordinateStatistics;
  const auto rigorous = [](auto& p) {
    return only_if(std::isfinite(p->worst_case_rigorous.min), p->worst_case_rigorous);
  };
  return {
      {"coordinate", [](auto& p) { return coordinate_of(signal(p)); }},
      {"signal", [](auto& p) { return only_if(is_closed(signal(p)), loop_of(signal(p))); },
       "of a closed loop: closed_position or closed_torque", optional},
      {"unit", [](auto& p) { return signal(p).unit; }},
      {"worst_case", statistic(&Statistics::worst_case, Bound::worst_case), "of the linearized kinematics"},
      {"worst_case_rigorous", statistic(rigorous, Bound::worst_case_rigorous),
       "of the exact kinematics; null: no bound"},
      {"sigma", statistic(&Statistics::sigma, Bound::sigma), "IPQN"},
      {"share", share(&Statistics::share), "of each encoder in the variance; not of a length", optional},
      {"share_worst_case", share(&Statistics::share_worst_case), optional}};
}

RowsOf<Derivative> rows(Of<Derivative>) {
  using Statistics = DerivativeStatistics;
  return {{"coordinate", [](auto& d) { return signal(d).name; }},
          {"unit", [](auto& d) { return derivative_unit(signal(d).unit, d.whole->filter); }},
          {"worst_case", statistic(&Statistics::worst_case, Bound::worst_case)},
          {"sigma", statistic(&Statistics::sigma, Bound::sigma), "IPQN; null: it depends on the motion"},
          {"sigma_quantization", statistic(&Statistics::sigma_quantization, Bound::sigma_quantization),
           "beside other errors: of quantization alone", optional},
          {"sigma_in_motion", statistic(&Statistics::sigma_in_motion, Bound::sigma_in_motion),
           "with encoders that move as in `motion:`", optional}};
}

RowsOf<FilteredTip> rows(Of<FilteredTip>) {
  return {{"filter", &NamedFilter::name},
          {"derivative", [](auto& f) { return f->filter.derivative; }},
          {"h2_norm", [](auto& f) { return f->norms.h2; }},
          {"l1_norm", [](auto& f) { return f->norms.l1; }},
          {"signal", [](auto& f) { return only_if(f->controller, std::string("torque")); },
           "of a joint's controller", optional},
          {"coordinates", passed},
          {"covariance", covariance_behind},
          {"noise_in_motion_over_ipqn", noise_over_ipqn, named_numbers_or_null(), "per encoder", optional}};
}

auto of_play(double PlayCycle::*figure) {
  return [figure](auto& c) { return c.play ? std::optional(c.play.value().*figure) : std::nullopt; };
}

RowsOf<LimitCycle> rows(Of<LimitCycle>) {
  return {{"bound", &LimitCycle::bound,
           "proven: no lasting motion due to quantization and play is larger [rad or m]"},
          {"torque_bound", &LimitCycle::torque_bound, "likewise, of the torque [N m or N]"},
          {"on_count", &LimitCycle::on_count, "one about a count is predicted"},
          {"on_edge", &LimitCycle::on_edge, "one about the edge between two counts is predicted"},
          {"edge_amplitude", &LimitCycle::edge_amplitude, "of the motion predicted there [rad or m]"},
          {"frequency", &LimitCycle::frequency, "predicted [Hz]"},
          {"torque_step", &LimitCycle::torque_step, "largest torque that follows one count [N m or N]"},
          {"ending_friction", &LimitCycle::ending_friction,
           "Coulomb friction that ends one between two counts [N m or N]"},
          {"play_amplitude", of_play(&PlayCycle::amplitude), "of the motion that play keeps alive [rad or m]",
           optional},
          {"play_frequency", of_play(&PlayCycle::frequency), "predicted, as its amplitude [Hz]", optional}};
}

RowsOf<ReportedLoop> rows(Of<ReportedLoop>) {
  return {
      {"joint", [](auto& l) { return joint_name(l.whole, l->joint); }},
      {"stable", &WorstLoop::stable, "at all inertias"},
      {"inertia",
       [](auto& l) {
         return Interval{l->least_inertia, l->largest_inertia};
       },
       "over the configurations [kg m^2 or kg]"},
      {"gain_margin", [](auto& l) { return l->margins.gain; },
       "least factor at which the loop is unstable, null: none; of an unstable loop below which it is not",
       nullable},
      {"lower_gain_margin", of_margins(&LoopMargins::lower_gain), "largest factor below 1, 0: none",
       nullable},
      {"phase_margin", of_margins(&LoopMargins::phase), "rad; null: the gain is never 1", nullable},
      {"crossover", of_margins(&LoopMargins::crossover), "Hz", nullable},
      {"bandwidth", of_margins(&LoopMargins::bandwidth), "Hz, of the closed loop", nullable},
      {"absolutely_stable", [](auto& l) { return l->margins.absolutely_stable; },
       "no oscillation between counts exists (Tsypkin)"},
      {"limit_cycle", [](auto& l) { return only_if(l->stable, l->cycle); }, "of a stable loop", optional}};
}

RowsOf<ReportedWall> rows(Of<ReportedWall>) {
  return {
      {"wall", [](auto& w) { return w->name; }},
      {"stiffness", [](auto& w) { return w->limit.stiffness(); }, "least that stays passive [N/m]", nullable},
      {"decided_by", [](auto& w) { return w->limit.by_quantization() ? "quantization" : "sampling"; },
       one_of({"quantization", "sampling"})},
      {"joint", [](auto& w) { return joint_name(w.whole, w->limit.joint()); },
       "whose friction or damping decides"},
      {"limit_of_rate", [](auto& w) { return w->sampling; }, "least, with the finest encoders [N/m]",
       nullable},
      {"limit_of_counts", [](auto& w) { return w->quantization; }, "least, with the fastest loop [N/m]",
       nullable},
      {"at", [](auto& w) { return by_joint(w.whole.spec, w->at); }, "joints where it is least"}};
}

RowsOf<ReportedGain> rows(Of<ReportedGain>) {
  return {{"joint", [](auto& g) { return joint_name(g.whole, g->joint); }},
          {"kd_max", &GainReport::kd, "largest kd that meets it, kp as stated; 0: none [N m s/rad or N s/m]"},
          {"quantity", &GainReport::quantity, "the requirement that limits it"}};
}

RowsOf<ReportedTorque> rows(Of<ReportedTorque>) {
  return {
      {"joint", [](auto& t) { return joint_name(t.whole, t->joint); }},
      {"worst_case", &OpenTorque::worst_case, "loop open, means aside, largest [N m or N]"},
      {"of_effort_limit", &OpenTorque::relative, "worst_case over the URDF's limit; null: none is stated"},
      {"share", [](auto& t) { return by_joint(t.whole.spec, t->share); },
       "of each encoder in the worst case, averaged over the configurations"}};
}

RowsOf<ReportedControl> rows(Of<ReportedControl>) {
  return {{"torques", &ReportedControl::torques, "of joints with a controller"},
          {"loops", &ReportedControl::loops, "of joints whose inertia is known"},
          {"walls", &ReportedControl::walls},
          {"gains", &ReportedControl::gains, "of joints with a requirement on their torque"}};
}

RowsOf<EffectDetail> rows(Of<EffectDetail>) {
  return {{"name", &EffectDetail::name},
          {"value", &EffectDetail::value, Schema{{{"type", Json::array({"number", "string", "null"})}}}},
          {"unit", &EffectDetail::unit}};
}

RowsOf<ReportedEffect> rows(Of<ReportedEffect>) {
  return {{"effect", [](auto& e) { return e->effect.type; }},
          {"joint", [](auto& e) { return e->effect.joint; }},
          {"stage", [](auto& e) { return stage_name(effect_kind(e->effect.type).stage); }},
          {"unit", [](auto& e) { return effect_unit(e.whole.spec, *e); }},
          {"mean", share([](const Share& s) { return s.mean; })},
          {"worst_case", share([](const Share& s) { return std::abs(s.mean) + s.half_width; })},
          {"sigma", share([](const Share& s) { return s.sigma; })},
          {"counted", &EffectShare::included, "false: it concerns the log or the reference only"},
          {"parameters", effect_details}};
}

RowsOf<ErrorEllipsoid> rows(Of<ErrorEllipsoid>) {
  return {
      {"semi_axes", &ErrorEllipsoid::semi_axes, "of one sigma, the largest first"},
      {"directions", [](auto& e) { return nested(e.directions.transpose()); }, "unit vectors along them"}};
}

RowsOf<In<TipEllipsoids, Analysis>> rows(Of<In<TipEllipsoids, Analysis>>) {
  return {
      {"of", &TipEllipsoids::of, one_of({"position", "rotation"})},
      {"unit", &TipEllipsoids::unit},
      {"frame", [](auto& e) { return e.whole.spec.model.frame == CoordinateFrame::tip ? "tip" : "base"; },
       one_of({"base", "tip"}), "in whose axes the directions are"},
      {"mean", &TipEllipsoids::mean, "of the mean covariance"},
      {"at_largest", &TipEllipsoids::at_largest, "where the trace of the position's covariance is largest"}};
}

RowsOf<Exceedance::Shell> rows(Of<Exceedance::Shell>) {
  using Shell = Exceedance::Shell;
  return {{"from", &Shell::from},
          {"to", &Shell::to},
          {"count", &Shell::count, "configurations"},
          {"above", &Shell::above, "of these, above the limit"}};
}

RowsOf<Exceedance> rows(Of<Exceedance>) {
  return {{"quantity", &Exceedance::quantity, "as in requirements"},
          {"limit", &Exceedance::limit},
          {"unit", &Exceedance::unit},
          {"count", &Exceedance::count, "configurations"},
          {"above", &Exceedance::above, "of these, above the limit"},
          {"share", [](auto& e) { return static_cast<double>(e.above) / static_cast<double>(e.count); }},
          {"by_distance", &Exceedance::by_distance, "distances of the tip from the origin of the base"},
          {"lowest", &Exceedance::lowest, numbers_or_null(),
           "x y z of the tip above the limit; null without any"},
          {"highest", &Exceedance::highest, numbers_or_null()}};
}

RowsOf<BudgetParts> rows(Of<BudgetParts>) {
  return {{"quantization", &BudgetParts::quantization},
          {"accuracy", &BudgetParts::accuracy, "as a sine of that amplitude"},
          {"effects", &BudgetParts::effects, "attributed to the encoder"}};
}

RowsOf<Analysis> rows(Of<Analysis>) {
  return analysis_header<Analysis>("analyze", [](const Analysis& a) -> const Analysis& { return a; })
      .with(
          {{"joints", within([](auto& a) { return a.spec.model.chain.independent; })},
           {"position", within([](auto& a) { return a.workspace.coordinates; })},
           {"derivatives", within([](auto& a) { return a.spec.filters; })},
           {"covariance",
            {{"mean", [](auto& a) { return nested(a.workspace.mean_covariance); }, "over the configurations"},
             {"at_largest", [](auto& a) { return nested(a.workspace.covariance_at_largest); },
              "where its trace is largest"},
             {"coordinates",
              [](auto& a) {
                std::vector<std::string_view> names;
                for (const Coordinate c : a.spec.model.coordinates) names.push_back(info(c).name);
                return names;
              }},
             {"largest_at", [](auto& a) { return by_joint(a.spec, a.workspace.largest_at); }, "joints"}},
            "of the tip's position"},
           {"budget", budget, "share of each encoder in the variance of the tip"},
           {"budget_parts", parts_of_budget, "of each encoder's share; beside an `accuracy`", optional},
           {"ellipsoids", within(tip_ellipsoids), "of x y z and of rx ry rz, if all three are given"},
           {"exceedances", &Analysis::exceedances, "with --above", optional},
           {"control", control, "loops and walls of `control:`", optional},
           {"effects", within(&Analysis::effects)},
           {"warnings", &Analysis::warnings}});
}

std::string_view method_name(const Spec& spec) {
  const SamplingMethod method = spec.configurations.method;
  return method == SamplingMethod::sobol    ? "sobol"
         : method == SamplingMethod::random ? "random"
         : method == SamplingMethod::grid   ? "grid"
         : spec.points_file.empty()         ? "list"
                                            : "file";
}

std::vector<std::pair<std::string, double>> budget(const Analysis& a) {
  const std::vector<double> shares = encoder_budget(a);
  return by_joint(a.spec, Eigen::Map<const Eigen::VectorXd>(shares.data(), std::ssize(shares)));
}

RowsOf<ReportedProof> rows(Of<ReportedProof>) {
  return {{"lower", &ReportedProof::lower, "reached at `at`", nullable},
          {"upper", &ReportedProof::upper, "never exceeded, rounding included; null: no bound is known",
           nullable},
          {"gap", &ReportedProof::gap, "upper/lower - 1; null: unbounded", nullable},
          {"at", [](auto& p) { return by_joint(p.spec, p.at); }, "joints"}};
}

}  // namespace qerr
