#include "qerr/diagnose/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <numbers>
#include <set>
#include <utility>

#include "comparison.hpp"
#include "found_parameters.hpp"
#include "gain.hpp"
#include "model_choice.hpp"
#include "qerr/core/parallel.hpp"
#include "qerr/diagnose/evidence.hpp"
#include "qerr/diagnose/sanity.hpp"
#include "record_advice.hpp"
#include "scatter.hpp"
#include "select.hpp"
#include "tip.hpp"

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

/// What a joint's residual was before its readings were repaired; empty where they were not.
std::optional<double> before_repair(const Sanity& sane, const std::string& joint) {
  for (const Cause& c : sane.causes)
    if (c.effect.joint == joint && c.gain.rms_before != c.gain.rms_after)
      for (std::size_t i = 0; i < sane.rms_before.size(); ++i)
        if (sane.model.chain.independent[i].name == joint && sane.rms_before[i] > 0)
          return sane.rms_before[i];
  return std::nullopt;
}

/// The residual as it was recorded, where the gain has seen repaired readings: the squares of all blocks are
/// scaled, so that they add up to it.
void undo_repair(HeldOut& held, double rms_before) {
  double squares = 0, rows = 0;
  for (const HeldOut::Block& b : held.blocks) squares += b.before, rows += b.rows;
  if (squares <= 0) return;
  const double factor = rms_before * rms_before * rows / squares;
  for (HeldOut::Block& b : held.blocks) b.before *= factor;
}

/// What the rows of one encoder say.
struct Finding {
  Evidence evidence;  ///< its independent rows
  std::optional<Selection> selection;
  Scatter scatter;
  HeldOut held;
};

/// Every encoder by itself, side by side.
std::vector<std::unique_ptr<Finding>> findings_of(const std::vector<Evidence>& all, const Sanity& sane,
                                                  const DiagnoseOptions& options) {
  std::vector<std::unique_ptr<Finding>> findings(all.size());
  parallel_for(all.size(), options.threads, [&](std::size_t i) {
    const std::vector<RowGroup> groups = independent_rows(all[i]);
    auto f = std::make_unique<Finding>();
    f->evidence = independent(all[i], groups);
    f->selection.emplace(select(f->evidence));
    f->scatter = scatter_of(f->evidence, f->selection->model);
    f->held = hold_out(all[i], f->evidence, groups, f->selection->model);
    if (const auto before = before_repair(sane, all[i].joint)) undo_repair(f->held, *before);
    findings[i] = std::move(f);
  });
  return findings;
}

/// One encoder's causes, alternatives and remainders.
class Account {
 public:
  Account(Diagnosis& d, const Evidence& e, const Gain& gain) : d_(d), e_(e), gain_(gain) {}

  void of_terms(const Selection& s, const Scatter& scatter) {
    const auto parameters = found_parameters(e_, s.model);
    for (std::size_t i = 0; i < s.model.terms().size(); ++i) {
      const Term& t = s.model.terms()[i];
      Effect effect = t.effect;
      t.fill(effect, s.model.coefficients(i));
      if (!t.named()) {
        d_.unexplained.push_back({e_.joint, t.unnamed, order_of(effect), frequency_of(effect),
                                  std::sqrt(2.0) * size_of(s.model, i)});
        continue;
      }
      // Unequal states have a mean of their own.
      if (effect.type == "offset" && scatter.effect && scatter.effect->type == "state_width") continue;
      std::vector<std::string> others = twins(effect, e_);
      for (const Alternative& other : s.alternatives)
        if (other.term == i) others.push_back(other.effect.type);
      Cause cause{effect, parameters[i], s.p_values[i], gain_};
      cause.rms = std::sqrt(addition(t, s.model.coefficients(i)).square().mean());
      add(std::move(cause), others);
    }
  }

  void of_scatter(const Scatter& scatter) {
    // Beside something that has no name, what scatters is its remainder.
    double unnamed = 0;
    for (const Unnamed& u : d_.unexplained)
      if (u.joint == e_.joint) unnamed = std::max(unnamed, u.amplitude);
    if (scatter.size < unnamed) return;
    if (scatter.effect) {
      Cause cause{*scatter.effect, {}, scatter.p_value, gain_};
      for (const auto& [name, value] : scatter.effect->numbers) {
        const double half = scatter.relative_error * std::abs(value);
        cause.parameters.push_back({name, value, value - half, value + half});
      }
      std::vector<std::string> others;
      if (scatter.alternative) others.push_back(scatter.alternative->type);
      add(std::move(cause), others);
    } else if (scatter.structured && scatter.size > 0.1 * e_.step()) {
      d_.unexplained.push_back(
          {e_.joint, "structure without a period or a known shape", {}, {}, scatter.size});
    }
  }

 private:
  void add(Cause cause, const std::vector<std::string>& others) {
    std::set<std::string> told{cause.effect.type};
    for (const std::string& other : others)
      if (told.insert(other).second)
        d_.alternatives.push_back(
            {cause.effect.type, other, e_.joint, record_advice(cause.effect.type, other)});
    d_.causes.push_back(std::move(cause));
  }

  Diagnosis& d_;
  const Evidence& e_;
  const Gain& gain_;
};

/// Adds what the tip tells. Its gain is the whole one where no joint has a reference.
void add_tip(TipDiagnosis tip, bool joints_judged, Diagnosis& d) {
  if (tip.judged && !joints_judged) {
    d.gain = tip.gain;
    d.prismatic = true;
    d.reason.clear();
  }
  std::move(tip.causes.begin(), tip.causes.end(), std::back_inserter(d.causes));
  std::move(tip.alternatives.begin(), tip.alternatives.end(), std::back_inserter(d.alternatives));
  std::move(tip.unexplained.begin(), tip.unexplained.end(), std::back_inserter(d.unexplained));
  std::move(tip.warnings.begin(), tip.warnings.end(), std::back_inserter(d.warnings));
}

Verdict verdict_of(const Diagnosis& d, bool judged) {
  const bool found = !d.causes.empty(), left = !d.unexplained.empty();
  if (!judged && !found && !left) return Verdict::cannot_judge;
  if (!found) return left ? Verdict::unexplained : Verdict::nothing_wrong;
  if (!d.alternatives.empty()) return Verdict::ambiguous;
  return left ? Verdict::partly_explained : Verdict::explained;
}

}  // namespace

Diagnosis diagnose(const OperationalModel& model, const std::vector<Filter>& filters,
                   const std::vector<Effect>& present, const Log& log, const DiagnoseOptions& options) {
  Sanity sane = check_sanity(model, filters, log, present);
  Diagnosis d;
  d.causes = sane.causes;
  d.unexplained = std::move(sane.unexplained);
  d.warnings = std::move(sane.warnings);
  d.reason = std::move(sane.cannot_judge);
  const std::vector<Evidence> all = evidence(sane);
  d.simulation = comparison(all, filters, options);
  const auto findings = findings_of(all, sane, options);
  std::vector<HeldOut> held;
  for (const auto& finding : findings) {
    const Finding& f = *finding;
    held.push_back(f.held);
    const Gain of_joint = gain({f.held}, options.seed);
    for (Cause& cause : d.causes)
      if (cause.effect.joint == f.evidence.joint) cause.gain = of_joint;
    Account account(d, f.evidence, of_joint);
    account.of_terms(*f.selection, f.scatter);
    account.of_scatter(f.scatter);
  }
  d.prismatic =
      !all.empty() && std::all_of(all.begin(), all.end(), [](const Evidence& e) { return e.prismatic; });
  d.gain = gain(held, options.seed);
  for (const AlternativeCause& a : sane.alternatives)
    for (const Cause& c : d.causes)
      if (c.effect.type == a.instead_of && c.effect.joint == a.joint) d.alternatives.push_back(a);
  TipDiagnosis tip = diagnose_tip(sane.model, sane.present, sane.log);
  const bool judged = !all.empty() || tip.judged;
  if (!judged && !d.causes.empty()) {
    d.gain = d.causes.front().gain;
    d.warnings.push_back("positions are not judged: " + std::exchange(d.reason, ""));
  }
  std::stable_sort(d.causes.begin(), d.causes.end(), [](const Cause& a, const Cause& b) {
    return a.gain.rms_before * a.gain.rms_before - a.gain.rms_after * a.gain.rms_after >
           b.gain.rms_before * b.gain.rms_before - b.gain.rms_after * b.gain.rms_after;
  });
  add_tip(std::move(tip), !all.empty(), d);
  d.verdict = verdict_of(d, judged);
  return d;
}

}  // namespace qerr
