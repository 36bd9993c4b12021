#include "qerr/diagnose/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "qerr/diagnose/evidence.hpp"
#include "qerr/diagnose/sanity.hpp"
#include "select.hpp"

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

/// What a joint's residual was before its readings were repaired; empty where they were not.
std::optional<double> before_repair(const Sanity& sane, const std::string& joint) {
  for (const Cause& c : sane.causes)
    if (c.effect.joint == joint && c.gain.rms_before != c.gain.rms_after)
      for (std::size_t i = 0; i < sane.rms_before.size(); ++i)
        if (sane.model.chain.independent[i].name == joint && sane.rms_before[i] > 0)
          return sane.rms_before[i];
  return std::nullopt;
}

double rms(const Eigen::ArrayXd& x) { return x.size() ? std::sqrt(x.square().mean()) : 0; }

}  // namespace

Diagnosis diagnose(const OperationalModel& model, const std::vector<Filter>& filters,
                   const std::vector<Effect>&, const Log& log, const DiagnoseOptions&) {
  Sanity sane = check_sanity(model, filters, log);
  Diagnosis d;
  d.causes = sane.causes;
  d.unexplained = std::move(sane.unexplained);
  d.warnings = std::move(sane.warnings);
  d.reason = std::move(sane.cannot_judge);
  const std::vector<Evidence> all = evidence(sane.model, sane.log);
  double before = 0, after = 0, rows = 0;
  for (const Evidence& full : all) {
    const Evidence e = independent(full);
    const Selection s = select(e);
    const double joint_before = before_repair(sane, e.joint).value_or(rms(e.measured - e.reference));
    const double joint_after = rms(e.measured - e.reference - s.model.addition());
    before += joint_before * joint_before * static_cast<double>(e.rows());
    after += joint_after * joint_after * static_cast<double>(e.rows());
    rows += static_cast<double>(e.rows());
    for (std::size_t i = 0; i < s.model.terms().size(); ++i) {
      const Term& t = s.model.terms()[i];
      Effect effect = t.effect;
      t.fill(effect, s.model.coefficients(i));
      if (!t.named()) {
        d.unexplained.push_back({e.joint, t.unnamed, effect.number("order"), {}, effect.number("amplitude")});
        continue;
      }
      Cause cause{effect, {}, s.p_values[i], {}};
      cause.gain.rms_before = joint_before;
      cause.gain.rms_after = joint_after;
      for (const auto& [key, value] : effect.numbers) cause.parameters.push_back({key, value, value, value});
      d.causes.push_back(std::move(cause));
      for (const Alternative& a : s.alternatives)
        if (a.term == i) d.alternatives.push_back({effect.type, a.effect.type, e.joint, ""});
    }
  }
  if (rows > 0) d.gain.rms_before = std::sqrt(before / rows), d.gain.rms_after = std::sqrt(after / rows);
  for (const AlternativeCause& a : sane.alternatives)
    for (const Cause& c : d.causes)
      if (c.effect.type == a.instead_of && c.effect.joint == a.joint) d.alternatives.push_back(a);
  if (rows == 0 && !d.causes.empty()) {
    d.gain = d.causes.front().gain;
    d.warnings.push_back("positions are not judged: " + std::exchange(d.reason, ""));
  }
  d.verdict = all.empty() && d.causes.empty() && d.unexplained.empty() ? Verdict::cannot_judge
              : !d.alternatives.empty()                                ? Verdict::ambiguous
              : d.causes.empty() && d.unexplained.empty()              ? Verdict::nothing_wrong
              : d.causes.empty()                                       ? Verdict::unexplained
              : d.unexplained.empty()                                  ? Verdict::explained
                                                                       : Verdict::partly_explained;
  return d;
}

}  // namespace qerr
