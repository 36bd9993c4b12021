#include "diagnose/verdict/cause_report.hpp"

#include <cmath>
#include <set>

#include "core/statistics.hpp"
#include "diagnose/inference/found_parameters.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

std::optional<double> order_of(const Effect& e) {
  return e.numbers.count("order") ? std::optional(e.number("order")) : std::nullopt;
}

std::optional<double> frequency_of(const Effect& e) {
  return e.numbers.count("frequency") ? std::optional(e.number("frequency")) : std::nullopt;
}

/// Effects that no record of these signals can distinguish from the one found.
std::vector<std::string> inseparable_twins(const Effect& effect, const Evidence& e) {
  std::vector<std::string> names;
  for (const Twin& twin : effect_kind(effect.type).twins)
    if (twin.inseparable && twin.inseparable(effect, e)) names.emplace_back(twin.other);
  return names;
}

/// Adds one encoder's causes, alternatives and unexplained rest to a diagnosis. Borrows its arguments for one
/// call of `add`.
class CauseReport {
 public:
  CauseReport(Diagnosis& d, const Evidence& e, const Gain& gain) : d_(d), e_(e), gain_(gain) {}

  void add_terms(const Selection& s, const Scatter& scatter) {
    const auto parameters = found_parameters(e_, s.model);
    for (std::size_t i = 0; i < s.model.terms().size(); ++i) {
      const Term& t = s.model.terms()[i];
      Effect effect = t.effect;
      t.fill(effect, s.model.coefficients(i));
      if (!t.named()) {
        add_unnamed(t, effect, std::sqrt(2.0) * size_of(s.model, i));
        continue;
      }
      // Displaced edges have a mean of their own.
      if (t.constant && scatter.effect && !effect_kind(scatter.effect->type).random()) continue;
      std::vector<std::string> others = inseparable_twins(effect, e_);
      for (const Alternative& other : s.alternatives)
        if (other.term == i) others.push_back(other.effect.type);
      Cause cause{effect, parameters[i], s.p_values[i], gain_, 0};
      cause.rms = rms(addition(t, s.model.coefficients(i)));
      cause.rms_without = std::sqrt(gain_.rms_after * gain_.rms_after + s.lost[i]);
      add(std::move(cause), others);
    }
  }

  void add_scatter(const Scatter& scatter) {
    // Scatter smaller than an unnamed error is attributed to the misfit of its term.
    double unnamed = 0;
    for (const Unidentified& u : d_.unexplained)
      if (u.joint == e_.joint) unnamed = std::max(unnamed, u.amplitude);
    if (scatter.size < unnamed) return;
    if (scatter.effect) {
      Cause cause{*scatter.effect, {}, scatter.p_value, gain_, 0};
      for (const auto& [name, value] : scatter.effect->numbers) {
        const double half = scatter.relative_error * std::abs(value);
        cause.parameters.push_back({name, value, value - half, value + half});
      }
      std::vector<std::string> others;
      if (scatter.alternative) others.push_back(scatter.alternative->type);
      add(std::move(cause), others);
    } else if (!scatter.structure.empty() && scatter.size > 0.25 * e_.step()) {
      d_.unexplained.push_back({e_.joint, scatter.structure, {}, {}, scatter.size, scatter.shape});
    }
  }

 private:
  void add_unnamed(const Term& t, const Effect& filled, double amplitude) {
    Unidentified u{e_.joint, t.unnamed, order_of(filled), frequency_of(filled), amplitude, t.pattern};
    u.figures = filled.numbers;
    d_.unexplained.push_back(std::move(u));
  }

  void add(Cause cause, const std::vector<std::string>& others) {
    std::set<std::string> reported{cause.effect.type};
    for (const std::string& other : others)
      if (reported.insert(other).second)
        d_.alternatives.push_back(
            {cause.effect.type, other, e_.joint, std::string(record_advice(cause.effect.type, other))});
    d_.causes.push_back(std::move(cause));
  }

  Diagnosis& d_;
  const Evidence& e_;
  const Gain& gain_;
};

}  // namespace

void add(Diagnosis& d, const Finding& f, const Gain& gain) {
  CauseReport report(d, f.evidence(), gain);
  report.add_terms(*f.selection, f.scatter);
  report.add_scatter(f.scatter);
}

}  // namespace qerr
