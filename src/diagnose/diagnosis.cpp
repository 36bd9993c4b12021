#include "qerr/diagnose/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "comparison.hpp"
#include "found_parameters.hpp"
#include "gain.hpp"
#include "qerr/diagnose/evidence.hpp"
#include "record_advice.hpp"
#include "select.hpp"
#include "spread.hpp"
#include "with_effects.hpp"

namespace qerr {

std::string_view name(Verdict v) {
  switch (v) {
    case Verdict::nothing_wrong:
      return "nothing_wrong";
    case Verdict::explained:
      return "explained";
    case Verdict::partly_explained:
      return "partly_explained";
    case Verdict::ambiguous:
      return "ambiguous";
    case Verdict::unexplained:
      return "unexplained";
    case Verdict::cannot_judge:
      return "cannot_judge";
  }
  return "";
}

namespace {

std::optional<double> order_of(const Effect& e) {
  return e.numbers.count("order") ? std::optional(e.number("order")) : std::nullopt;
}

std::optional<double> frequency_of(const Effect& e) {
  return e.numbers.count("frequency") ? std::optional(e.number("frequency")) : std::nullopt;
}

/// Peak of what a term adds, taken for a sine.
double size_of(const Explanation& m, std::size_t term) {
  const Eigen::ArrayXd added = (m.terms()[term].columns.matrix() * m.coefficients(term)).array();
  return std::sqrt(2 * (added - added.mean()).square().mean());
}

/// What is the same by its nature, whatever was recorded.
std::vector<std::string> twins(const Effect& effect, const Evidence& e) {
  const bool half = std::abs(effect.number("offset") + 0.5 * e.step()) < 0.1 * e.step();
  if (effect.type == "offset" && half && e.encoder.rounding == Rounding::nearest) return {"truncation"};
  const auto shaft = effect.choices.find("shaft");
  const bool of_joint = shaft == effect.choices.end() || shaft->second == "joint" ||
                        std::abs(std::abs(e.encoder.shaft_ratio) - 1) < 1e-9;
  // Steppers, the usual references, err at 50 and 100 periods a turn.
  if (effect.type == "transmission_error" && of_joint && std::fmod(effect.number("order"), 50) == 0)
    return {"reference_error"};
  // Within the one period of a resolver its sine and cosine make what an eccentric disc makes.
  const double period = e.encoder.counts_per_period * e.step() * std::abs(e.encoder.shaft_ratio);
  const bool one_period =
      e.encoder.counts_per_period > 4 && std::abs(period / (2 * std::numbers::pi) - 1) < 1e-6;
  if (one_period && (effect.type == "eccentricity" || effect.type == "transmission_error"))
    return {"subdivision_error"};
  return {};
}

}  // namespace

Diagnosis diagnose(const OperationalModel& model, const std::vector<Filter>& filters,
                   const std::vector<Effect>& present, const Log& log, const DiagnoseOptions& options) {
  Diagnosis d;
  std::vector<Evidence> all = evidence(model, log);
  for (Evidence& e : all) e = with_effects(std::move(e), present);
  d.simulation = comparison(all, filters, options);
  std::vector<HeldOut> held;
  for (const Evidence& full : all) {
    const std::vector<Eigen::Index> starts = independent_rows(full);
    const Evidence e = independent(full, starts);
    const Selection s = select(e);
    held.push_back(hold_out(full, e, starts, s.model));
    const Gain joint_gain = gain({held.back()}, options.seed);
    const auto parameters = found_parameters(e, s.model);
    const Spread scatter = spread(e, s.model);
    for (std::size_t i = 0; i < s.model.terms().size(); ++i) {
      const Term& t = s.model.terms()[i];
      Effect effect = t.effect;
      t.fill(effect, s.model.coefficients(i));
      if (!t.named()) {
        d.unexplained.push_back(
            {e.joint, t.unnamed, order_of(effect), frequency_of(effect), size_of(s.model, i)});
        continue;
      }
      if (effect.type == "offset" && scatter.effect && scatter.effect->type == "state_width") continue;
      d.causes.push_back({effect, parameters[i], s.p_values[i], joint_gain});
      std::set<std::string> told{effect.type};
      const auto tell = [&](const std::string& other) {
        if (told.insert(other).second)
          d.alternatives.push_back({effect.type, other, e.joint, record_advice(effect.type, other)});
      };
      for (const Alternative& other : s.alternatives)
        if (other.term == i) tell(other.effect.type);
      for (const std::string& twin : twins(effect, e)) tell(twin);
    }
    if (scatter.effect) {
      d.causes.push_back({*scatter.effect, {}, scatter.p_value, joint_gain});
      for (const auto& [name, value] : scatter.effect->numbers)
        d.causes.back().parameters.push_back({name, value, value, value});
      if (scatter.alternative)
        d.alternatives.push_back({scatter.effect->type, scatter.alternative->type, e.joint,
                                  record_advice(scatter.effect->type, scatter.alternative->type)});
    } else if (scatter.structured && scatter.size > 0.1 * e.step()) {
      d.unexplained.push_back({e.joint, "structure without a period or a known shape", {}, {}, scatter.size});
    }
  }
  d.gain = gain(held, options.seed);
  std::stable_sort(d.causes.begin(), d.causes.end(),
                   [](const Cause& a, const Cause& b) { return a.gain.rms_before > b.gain.rms_before; });
  d.verdict = all.empty()                                 ? Verdict::cannot_judge
              : !d.alternatives.empty()                   ? Verdict::ambiguous
              : d.causes.empty() && d.unexplained.empty() ? Verdict::nothing_wrong
              : d.causes.empty()                          ? Verdict::unexplained
              : d.unexplained.empty()                     ? Verdict::explained
                                                          : Verdict::partly_explained;
  return d;
}

}  // namespace qerr
