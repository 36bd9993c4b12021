#include "diagnose/search/visible_effects.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

/// Why a record does not show an effect that its encoder can have.
std::string hidden_by(const EffectKind& kind, const Evidence& e) {
  if (kind.missing_signal)
    if (const auto missing = kind.missing_signal(e); missing && missing->effect == kind.name)
      return "not recorded: " + missing->needs;
  if (e.is_stationary()) return "standstill";
  if (!e.ordered) return "poses without order in time";
  if ((e.direction.abs() == 1).any() && (e.direction.minCoeff() > -1 || e.direction.maxCoeff() < 1))
    return "motion in one direction";
  return e.range() < 2 * std::numbers::pi ? "less than a turn"
                                          : "proportional to other errors in this motion";
}

/// The parameter that a term's size sets, and its value.
void set_smallest(VisibleEffect& v, const Term& t, double size) {
  Effect filled = t.effect;
  t.fill(filled, size * Eigen::VectorXd::Unit(t.size(), 0));
  for (const auto& [name, value] : filled.numbers)
    if (!t.effect.numbers.contains(name) || t.effect.numbers.at(name) != value)
      if (value != 0 && v.parameter.empty()) v.parameter = name, v.smallest = std::abs(value);
}

bool suits(const EffectKind& kind, const Encoder& encoder) {
  return !kind.encoder_need || (encoder.counts_per_period >= kind.encoder_need->least &&
                                encoder.counts_per_period <= kind.encoder_need->most);
}

}  // namespace

std::vector<VisibleEffect> visible_effects(const ErrorModel& m, const Choice& choice) {
  std::vector<VisibleEffect> visible;
  const double noise = m.scale(choice);
  for (const EffectKind& kind : effect_kinds()) {
    if (!kind.terms || !suits(kind, m.sampled().encoder)) continue;
    const auto of_kind = [&](std::size_t g) { return m.term(g).effect.type == kind.name; };
    if (std::any_of(choice.chosen.begin(), choice.chosen.end(), of_kind)) continue;
    VisibleEffect v{std::string(kind.name), {}, 0, {}};
    for (std::size_t g = 0; g < m.candidates().size() && v.smallest == 0; ++g) {
      if (!of_kind(g) || m.candidate(g).most > 0) continue;
      const double information = m.linear().least_information(m.groups(), choice.chosen, g);
      if (information > 0)
        set_smallest(v, m.term(g),
                     std::sqrt((m.group(g).least_gain + m.group(g).price * noise) / information));
    }
    if (v.smallest == 0) v.hidden_by = hidden_by(kind, m.sampled());
    visible.push_back(std::move(v));
  }
  return visible;
}

}  // namespace qerr
