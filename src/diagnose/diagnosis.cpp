#include "qerr/diagnose/diagnosis.hpp"

#include <algorithm>
#include <cmath>

#include "qerr/diagnose/evidence.hpp"
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

double rms(const Eigen::ArrayXd& x) { return x.size() ? std::sqrt(x.square().mean()) : 0; }

}  // namespace

Diagnosis diagnose(const OperationalModel& model, const std::vector<Filter>&, const std::vector<Effect>&,
                   const Log& log, const DiagnoseOptions&) {
  Diagnosis d;
  const std::vector<Evidence> all = evidence(model, log);
  double before = 0, after = 0, rows = 0;
  for (const Evidence& full : all) {
    const Evidence e = independent(full);
    const Selection s = select(e);
    const double joint_before = rms(e.measured - e.reference);
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
  d.verdict = all.empty()                                 ? Verdict::cannot_judge
              : !d.alternatives.empty()                   ? Verdict::ambiguous
              : d.causes.empty() && d.unexplained.empty() ? Verdict::nothing_wrong
              : d.causes.empty()                          ? Verdict::unexplained
              : d.unexplained.empty()                     ? Verdict::explained
                                                          : Verdict::partly_explained;
  return d;
}

}  // namespace qerr
