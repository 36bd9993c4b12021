#include "qerr/effect/effect.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/random.hpp"
#include "effect/effects/effects.hpp"

namespace qerr {

const std::vector<EffectKind>& effect_kinds() {
  static const std::vector<EffectKind> kinds{
      offset_effect(),
      scale_effect(),
      eccentricity_effect(),
      transmission_error_effect(),
      subdivision_error_effect(),
      state_width_effect(),
      missed_counts_effect(),
      decoding_effect(),
      truncation_effect(),
      backlash_effect(),
      compliance_effect(),
      latency_effect(),
      timing_jitter_effect(),
      clock_drift_effect(),
      noise_effect(),
      drift_effect(),
      rollover_effect(),
      geometry_effect(),
      reference_error_effect(),
      log_rounding_effect(),
  };
  return kinds;
}

const EffectKind& effect_kind(std::string_view name) {
  const auto& kinds = effect_kinds();
  const auto found = std::find_if(kinds.begin(), kinds.end(), [&](const auto& k) { return k.name == name; });
  if (found == kinds.end()) throw std::out_of_range("no effect '" + std::string(name) + "'");
  return *found;
}

double Effect::number(const std::string& name) const {
  if (const auto given = numbers.find(name); given != numbers.end()) return given->second;
  const auto& rows = effect_kind(type).parameters;
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const Parameter& p) { return p.name == name; });
  if (row == rows.end()) throw std::out_of_range("effect '" + type + "' has no parameter '" + name + "'");
  return row->fallback.value_or(0);
}

Eigen::Vector3d displacement_direction(const Effect& effect) {
  const std::string& axis = effect.choices.at("axis");
  return Eigen::Vector3d::Unit(axis == "x" ? 0 : axis == "y" ? 1 : 2);
}

std::string_view stage_name(Stage stage) {
  switch (stage) {
    case Stage::clock:
      return "clock";
    case Stage::link:
      return "link";
    case Stage::gear:
      return "gear";
    case Stage::disc:
      return "disc";
    case Stage::line:
      return "line";
    case Stage::comparator:
      return "comparator";
    case Stage::decoder:
      return "decoder";
    case Stage::log:
      return "log";
    case Stage::reference:
      return "reference";
    case Stage::kinematics:
      return "kinematics";
  }
  return "";
}

std::optional<Share> proportional(double factor, const std::optional<Spread>& quantity) {
  if (factor == 0) return Share{};
  if (!quantity) return std::nullopt;
  // A zero is kept from being a negative one.
  return Share{0.0 + factor * quantity->middle(),
               std::abs(factor) * quantity->half(),
               std::abs(factor) * quantity->stray(),
               Course::motion,
               {},
               quantity->rate};
}

double normal(std::uint64_t seed, std::uint64_t index) {
  // Box and Muller; 1 - u is never 0.
  const double u = unit_interval(random_bits(seed, index, 0)), v = unit_interval(random_bits(seed, index, 1));
  return std::sqrt(-2 * std::log1p(-u)) * std::cos(2 * std::numbers::pi * v);
}

}  // namespace qerr
