#include <cmath>

#include "qerr/effect/effect_kind.hpp"
#include "qerr/kinematics/coordinates.hpp"
#include "report/analysis/count_rates.hpp"
#include "report/analysis/effects.hpp"
#include "report/analysis/ellipsoids.hpp"
#include "report/analysis/json_header.hpp"
#include "report/formats.hpp"

namespace qerr {

namespace {

Json statistic(const Analysis& a, const Statistic& s, const Figure& figure) {
  Json object;
  for (const StatisticKind& kind : statistic_kinds()) object[kind.name] = s.*kind.value;
  object["at_max"] = by_joint(a.spec, s.at_max);
  if (const ProvenMaximum* proven = find_proof(a, figure)) object["proven"] = proven_json(a.spec, *proven);
  return object;
}

/// Null for a quantity without a bound.
Json statistic_or_null(const Analysis& a, const Statistic& s, const Figure& figure) {
  return std::isfinite(s.min) ? statistic(a, s, figure) : Json(nullptr);
}

Json matrix(const Eigen::MatrixXd& m) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < m.cols(); ++j) row.push_back(m(i, j));
    rows.push_back(row);
  }
  return rows;
}

Json covariance(const Eigen::MatrixXd& mean, const Eigen::MatrixXd& at_largest) {
  return {{"mean", matrix(mean)}, {"at_largest", matrix(at_largest)}};
}

Json covariance_behind(const Analysis& a, std::size_t filter) {
  const Workspace& w = a.workspace;
  if (filter < w.filtered.size() && w.filtered[filter].mean_covariance.size() == 0) return {};
  if (filter < w.filtered.size())
    return covariance(w.filtered[filter].mean_covariance, w.filtered[filter].covariance_at_largest);
  const double h2 = a.spec.filters[filter].norms.h2, factor = h2 * h2;
  return covariance(factor * w.mean_covariance, factor * w.covariance_at_largest);
}

/// Figures of unknown size are null; `counted` is false for an effect on the log or the reference only.
Json effects(const Analysis& a) {
  Json list = Json::array();
  for (const EffectShare& s : a.effects) {
    Json entry = {{"effect", s.effect.type},
                  {"joint", s.effect.joint},
                  {"stage", stage_name(effect_kind(s.effect.type).stage)},
                  {"unit", effect_unit(a.spec, s)},
                  {"mean", nullptr},
                  {"worst_case", nullptr},
                  {"sigma", nullptr},
                  {"counted", s.included},
                  {"parameters", Json::array()}};
    if (s.share) {
      entry["mean"] = s.share->mean;
      entry["worst_case"] = std::abs(s.share->mean) + s.share->half_width;
      entry["sigma"] = s.share->sigma;
    }
    for (const EffectParameter& p : effect_parameters(a.spec, s.effect))
      entry["parameters"].push_back({{"name", p.name}, {"value", p.value}, {"unit", p.unit}});
    for (const auto& [name, word] : s.effect.choices)
      entry["parameters"].push_back({{"name", name}, {"value", word}, {"unit", ""}});
    list.push_back(entry);
  }
  return list;
}

Json joints(const Analysis& a) {
  Json list = Json::array();
  const Spec& spec = a.spec;
  EncoderSpeeds speeds;
  for (std::size_t i = 0; i < spec.model.chain.independent.size(); ++i) {
    const IndependentJoint& joint = spec.model.chain.independent[i];
    const auto row = static_cast<Eigen::Index>(i);
    list.push_back({{"name", joint.name},
                    {"unit", joint.prismatic() ? "m" : "rad"},
                    {"resolution", a.resolutions[static_cast<Eigen::Index>(i)]},
                    {"worst_case", a.joints.worst_case[row]},
                    {"sigma", a.joints.sigma[row]},
                    {"mean", a.joints.mean[row]}});
    const double accuracy = spec.model.transmission.encoders[i].accuracy;
    if (accuracy > 0) list.back()["accuracy"] = accuracy;
    const double of_gear = spec.model.transmission.encoders[i].gear_accuracy;
    if (of_gear > 0) list.back()["gear_accuracy"] = of_gear;
    const std::optional<CountLimit> limit = count_limit(spec, i);
    if (!limit) continue;
    if (speeds.empty()) speeds = encoder_speeds(spec);
    list.back()["count_rate"] = speeds[i] ? Json(count_rate(spec, i, *speeds[i])) : Json();
    list.back()["max_count_rate"] = limit->rate;
  }
  return list;
}

Json position(const Analysis& a) {
  Json list = Json::array();
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  for (std::size_t i = 0; i < a.workspace.coordinates.size(); ++i) {
    const CoordinateStatistics& c = a.workspace.coordinates[i];
    const Signal& row = coordinates[i];
    list.push_back({{"coordinate", row.name},
                    {"unit", row.unit},
                    {"worst_case", statistic(a, c.worst_case, {i, -1, Bound::worst_case})},
                    {"worst_case_rigorous",
                     statistic_or_null(a, c.worst_case_rigorous, {i, -1, Bound::worst_case_rigorous})},
                    {"sigma", statistic(a, c.sigma, {i, -1, Bound::sigma})}});
    if (c.share.size() == 0) continue;
    list.back()["share"] = by_joint(a.spec, c.share);
    list.back()["share_worst_case"] = by_joint(a.spec, c.share_worst_case);
  }
  return list;
}

Json derivatives(const Analysis& a) {
  Json list = Json::array();
  const std::vector<Signal> coordinates = all_signals(a.spec.model);
  for (std::size_t f = 0; f < a.spec.filters.size(); ++f) {
    const NamedFilter& filter = a.spec.filters[f];
    const auto index = static_cast<std::ptrdiff_t>(f);
    Json rows = Json::array();
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      const DerivativeStatistics& d = a.workspace.derivatives[f][i];
      rows.push_back({{"coordinate", coordinates[i].name},
                      {"unit", derivative_unit(coordinates[i].unit, filter.filter)},
                      {"worst_case", statistic(a, d.worst_case, {i, index, Bound::worst_case})},
                      {"sigma", d.sigma ? statistic(a, *d.sigma, {i, index, Bound::sigma}) : Json()}});
      if (d.sigma_quantization)
        rows.back()["sigma_quantization"] =
            statistic(a, *d.sigma_quantization, {i, index, Bound::sigma_quantization});
      if (d.sigma_in_motion)
        rows.back()["sigma_in_motion"] = statistic(a, *d.sigma_in_motion, {i, index, Bound::sigma_in_motion});
    }
    list.push_back({{"filter", filter.name},
                    {"derivative", filter.filter.derivative},
                    {"h2_norm", filter.norms.h2},
                    {"l1_norm", {{"lower", filter.norms.l1.lower}, {"upper", filter.norms.l1.upper}}},
                    {"coordinates", rows},
                    {"covariance", covariance_behind(a, f)}});
    if (is_known(a.noise_in_motion, f))
      list.back()["noise_in_motion_over_ipqn"] =
          by_joint(a.spec, a.noise_in_motion[f] * (std::sqrt(12.0) / filter.norms.h2));
  }
  return list;
}

Json parts_of_budget(const Analysis& a) {
  Json object = Json::object();
  const std::vector<BudgetParts> parts = budget_parts(a);
  for (std::size_t e = 0; e < parts.size(); ++e)
    object[a.spec.model.chain.independent[e].name] = {{"quantization", parts[e].quantization},
                                                      {"accuracy", parts[e].accuracy},
                                                      {"effects", parts[e].effects}};
  return object;
}

Json ellipsoid(const ErrorEllipsoid& e) {
  return {{"semi_axes", e.semi_axes}, {"directions", matrix(e.directions.transpose())}};
}

Json ellipsoids(const Analysis& a) {
  Json list = Json::array();
  for (const TipEllipsoids& tip : tip_ellipsoids(a))
    list.push_back({{"of", tip.of},
                    {"unit", tip.unit},
                    {"frame", a.spec.model.frame == CoordinateFrame::tip ? "tip" : "base"},
                    {"mean", ellipsoid(tip.mean)},
                    {"at_largest", ellipsoid(tip.at_largest)}});
  return list;
}

Json exceedances(const Analysis& a) {
  Json list = Json::array();
  for (const Exceedance& e : a.exceedances) {
    Json shells = Json::array();
    for (const Exceedance::Shell& s : e.by_distance)
      shells.push_back({{"from", s.from}, {"to", s.to}, {"count", s.count}, {"above", s.above}});
    list.push_back({{"quantity", e.quantity},
                    {"limit", e.limit},
                    {"unit", e.unit},
                    {"count", e.count},
                    {"above", e.above},
                    {"share", static_cast<double>(e.above) / static_cast<double>(e.count)},
                    {"by_distance", shells},
                    {"lowest", e.lowest},
                    {"highest", e.highest}});
  }
  return list;
}

}  // namespace

Json report_json(const Analysis& a) {
  Json j = analysis_header(a, "analyze");
  j["joints"] = joints(a);
  j["position"] = position(a);
  j["derivatives"] = derivatives(a);
  j["covariance"] = covariance(a.workspace.mean_covariance, a.workspace.covariance_at_largest);
  Json names = Json::array();
  for (const Coordinate c : a.spec.model.coordinates) names.push_back(info(c).name);
  j["covariance"]["coordinates"] = names;
  j["covariance"]["largest_at"] = by_joint(a.spec, a.workspace.largest_at);
  const std::vector<double> budget = encoder_budget(a);
  j["budget"] = by_joint(
      a.spec, Eigen::Map<const Eigen::VectorXd>(budget.data(), static_cast<Eigen::Index>(budget.size())));
  if (states_accuracy(a.spec)) j["budget_parts"] = parts_of_budget(a);
  j["ellipsoids"] = ellipsoids(a);
  if (!a.exceedances.empty()) j["exceedances"] = exceedances(a);
  j["effects"] = effects(a);
  j["warnings"] = a.warnings;
  return j;
}

std::string to_json(const Analysis& a, const Style&) { return report_json(a).document(); }

}  // namespace qerr
