#include <cmath>

#include "qerr/effect/effect_kind.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/count_rates.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/ellipsoids.hpp"
#include "report/analysis/json_header.hpp"

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

auto share(Eigen::VectorXd CoordinateStatistics::*shares) {
  return [shares](const Position& p) {
    return only_if(((*p).*shares).size() > 0, by_joint(p.whole.spec, (*p).*shares));
  };
}

struct Covariance {
  Eigen::MatrixXd mean, at_largest;
};

std::optional<Covariance> covariance_behind(const FilteredTip& f) {
  const Workspace& w = f.whole.workspace;
  const double factor = f->norms.h2 * f->norms.h2;
  if (f.i >= w.filtered.size())
    return Covariance{factor * w.mean_covariance, factor * w.covariance_at_largest};
  const auto& behind = w.filtered[f.i];
  return only_if(behind.mean_covariance.size() > 0,
                 Covariance{behind.mean_covariance, behind.covariance_at_largest});
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
  return [value](const AnalyzedJoint& j) { return (j.whole.joints.*value)[static_cast<Eigen::Index>(j.i)]; };
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

RowsOf<Covariance> rows(Of<Covariance>) {
  return {{"mean", [](auto& c) { return nested(c.mean); }, "over the configurations"},
          {"at_largest", [](auto& c) { return nested(c.at_largest); }, "where its trace is largest"}};
}

RowsOf<AnalyzedJoint> rows(Of<AnalyzedJoint>) {
  return {{"name", &IndependentJoint::name},
          {"unit", [](auto& j) { return j->prismatic() ? "m" : "rad"; }},
          {"resolution", [](auto& j) { return j.whole.resolutions[static_cast<Eigen::Index>(j.i)]; },
           "of the encoder, at the joint side"},
          {"worst_case", error(&JointError::worst_case), "of the joint, after the coupling"},
          {"sigma", error(&JointError::sigma)},
          {"mean", error(&JointError::mean)},
          {"accuracy", encoder(&Encoder::accuracy), "of the encoder, at the joint side", optional},
          {"gear_accuracy", encoder(&Encoder::gear_accuracy), "at the joint", optional},
          {"count_rate", rate, "counts/s; where a limit is stated", optional},
          {"max_count_rate", most_rate, "counts/s", optional}};
}

RowsOf<Position> rows(Of<Position>) {
  using Statistics = CoordinateStatistics;
  const auto rigorous = [](auto& p) {
    return only_if(std::isfinite(p->worst_case_rigorous.min), p->worst_case_rigorous);
  };
  return {
      {"coordinate", [](auto& p) { return signal(p).name; }},
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
          {"coordinates", within([](auto& f) { return f.whole.workspace.derivatives[f.i]; })},
          {"covariance", covariance_behind},
          {"noise_in_motion_over_ipqn", noise_over_ipqn, named_numbers_or_null(), "per encoder", optional}};
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
           {"effects", within(&Analysis::effects)},
           {"warnings", &Analysis::warnings}});
}

}  // namespace qerr
