#include "qerr/report/analysis.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace qerr {

namespace {

/// Parts of a variance below this are squares of rounding errors.
constexpr double rounding = 1e-24;

/// Within 5 degrees of the gimbal lock a roll or yaw error is more than ten times the rotation that causes
/// it.
constexpr double near_gimbal_lock = 0.0872;

std::vector<std::string> warnings_of(const Spec& spec, const Workspace& w) {
  std::vector<std::string> warnings = spec.warnings;
  const auto& coordinates = spec.model.coordinates;
  const bool euler = std::any_of(coordinates.begin(), coordinates.end(),
                                 [](Coordinate c) { return c == Coordinate::roll || c == Coordinate::yaw; });
  if (euler && w.smallest_cosine_of_pitch < near_gimbal_lock)
    warnings.push_back(
        "roll and yaw: the samples come within " +
        shortest(std::round(10 * std::asin(w.smallest_cosine_of_pitch) * 180 / std::numbers::pi) / 10) +
        " deg of the gimbal lock (pitch = +-90 deg), where their errors grow without bound; use rx ry rz");
  warnings.push_back(
      "quantization only: backlash, calibration, compliance and noise are not in these figures");
  if (!spec.filters.empty()) {
    warnings.push_back(
        "sigma of a derivative assumes white quantization noise (IPQN): true on average over speeds, at no "
        "constant "
        "speed exactly, and false below about one count per sample");
    warnings.push_back(
        "worst case of a derivative assumes a Jacobian that is constant over the filter's memory");
  }
  for (const NamedFilter& f : spec.filters)
    if (f.filter.derivative > 0 && std::abs(f.norms.dc_gain) > 1e-9 * f.norms.h2)
      warnings.push_back(
          "filter '" + f.name +
          "' is said to estimate a derivative and passes constants: H(1) = " + shortest(f.norms.dc_gain));
  if (!spec.effects.empty())
    warnings.push_back("the spec's effects are not in these figures: they are of the ideal encoders");
  if (!w.exact_percentiles) warnings.push_back("percentiles are counted in bins: right to 1.3e-4 relative");
  return warnings;
}

}  // namespace

Analysis analyze(const Spec& spec, const WorkspaceOptions& options) {
  std::vector<Norms> norms;
  for (const NamedFilter& filter : spec.filters) norms.push_back(filter.norms);
  Analysis a{spec,
             joint_error(spec.model.transmission),
             workspace(spec.model, norms, spec.configurations, options),
             {}};
  a.warnings = warnings_of(spec, a.workspace);
  return a;
}

std::string derivative_unit(Coordinate c, int derivative) {
  Dimension d = info(c).unit == "m" ? dimension::length : dimension::angle;
  d.second = -derivative;
  return unit_name(d);
}

std::vector<double> encoder_budget(const Analysis& a) {
  const auto& coordinates = a.spec.model.coordinates;
  const bool positions = std::any_of(coordinates.begin(), coordinates.end(), is_position);
  std::vector<double> parts(a.spec.model.transmission.encoders.size());
  double total = 0;
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    if (is_position(coordinates[i]) != positions) continue;
    for (std::size_t e = 0; e < parts.size(); ++e) {
      const double part =
          a.workspace.mean_variance_parts(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(e));
      if (!std::isfinite(part)) continue;
      parts[e] += part;
      total += part;
    }
  }
  if (total > 0)
    for (double& part : parts) part = part > rounding * total ? part / total : 0;
  return parts;
}

}  // namespace qerr
