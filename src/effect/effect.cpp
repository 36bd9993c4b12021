#include "qerr/effect/effect.hpp"

#include <array>
#include <numbers>
#include <stdexcept>

#include "core/random.hpp"
#include "effect/effects/effects.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

const std::vector<EffectKind>& cause_kinds() {
  static const std::vector<EffectKind> kinds{
#define QERR_EFFECT(name) name##_effect(),
#include "effect/effects/list.inc"
#undef QERR_EFFECT
  };
  return kinds;
}

const std::vector<EffectKind>& effect_kinds() {
  static const std::vector<EffectKind> kinds = [] {
    std::vector<EffectKind> effects = cause_kinds();
    std::erase_if(effects, [](const EffectKind& k) { return !k.spec_remedy.empty(); });
    return effects;
  }();
  return kinds;
}

const EffectKind* find_effect_kind(std::string_view name) {
  const auto& kinds = cause_kinds();
  const auto found = std::ranges::find_if(kinds, [&](const auto& k) { return k.name == name; });
  return found == kinds.end() ? nullptr : &*found;
}

const EffectKind& effect_kind(std::string_view name) {
  const EffectKind* found = find_effect_kind(name);
  if (!found) throw std::out_of_range("no effect '" + std::string(name) + "'");
  return *found;
}

double Effect::number(const std::string& name) const {
  if (const auto given = numbers.find(name); given != numbers.end()) return given->second;
  const auto& rows = effect_kind(type).parameters;
  const auto row = std::ranges::find_if(rows, [&](const Parameter& p) { return p.name == name; });
  if (row == rows.end()) throw std::out_of_range("effect '" + type + "' has no parameter '" + name + "'");
  return row->fallback.value_or(0);
}

bool has_size(const Effect& effect) {
  if (effect_kind(effect.type).jumps) return true;  // bit 0, stuck at 0
  return std::ranges::any_of(effect.numbers, [](const auto& n) { return n.second != 0; });
}

std::string_view record_advice(std::string_view one, std::string_view other) {
  const auto& kinds = cause_kinds();
  for (const EffectKind& kind : kinds)
    for (const Twin& twin : kind.twins)
      if (!twin.record.empty() &&
          ((kind.name == one && twin.other == other) || (kind.name == other && twin.other == one)))
        return twin.record;
  // If both rows have general advice, use that of the later row, which is more specific.
  for (auto kind = kinds.rbegin(); kind != kinds.rend(); ++kind)
    if (!kind->record.empty() && (kind->name == one || kind->name == other)) return kind->record;
  return "a richer motion: the whole range, several speeds, both directions, standstills in between";
}

Eigen::Vector3d displacement_direction(const Effect& effect) {
  const std::string& axis = effect.choices.at("axis");
  return Eigen::Vector3d::Unit(axis == "x" ? 0 : axis == "y" ? 1 : 2);
}

std::string_view stage_name(Stage stage) {
  constexpr std::array<std::string_view, 10> in_order{
      "clock", "link", "gear", "disc", "line", "comparator", "decoder", "log", "reference", "kinematics"};
  return in_order[static_cast<std::size_t>(stage)];
}

std::optional<Share> proportional(double factor, const std::optional<Spread>& quantity) {
  if (factor == 0) return Share{};
  if (!quantity) return std::nullopt;
  // Adding 0.0 turns -0.0 into 0.0.
  return Share{0.0 + factor * quantity->mid_range(), std::abs(factor) * quantity->half_width(),
               std::abs(factor) * quantity->rms_about_mid_range(), Spectrum::motion};
}

double normal(std::uint64_t seed, std::uint64_t index) {
  // Box and Muller; 1 - u is never 0.
  const double u = unit_interval(random_bits(seed, index, 0)), v = unit_interval(random_bits(seed, index, 1));
  return std::sqrt(-2 * std::log1p(-u)) * std::cos(2 * std::numbers::pi * v);
}

std::string_view name(Shape s) {
  constexpr std::array<std::string_view, 9> in_order{"step", "hysteresis", "exponential", "line",   "order",
                                                     "bump", "by_count",   "noise",       "unknown"};
  return in_order[static_cast<std::size_t>(s)];
}

}  // namespace qerr
