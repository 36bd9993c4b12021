#include "qerr/diagnose/diagnosis.hpp"

#include <algorithm>
#include <cmath>

#include "found_parameters.hpp"
#include "gain.hpp"
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
                   const Log& log, const DiagnoseOptions& options) {
  Diagnosis d;
  const std::vector<Evidence> all = evidence(model, log);
  d.prismatic =
      !all.empty() && std::all_of(all.begin(), all.end(), [](const Evidence& e) { return e.prismatic; });
  std::vector<HeldOut> held;
  for (const Evidence& full : all) {
    const std::vector<Eigen::Index> starts = independent_rows(full);
    const Evidence e = independent(full, starts);
    const Selection s = select(e);
    held.push_back(hold_out(full, e, starts, s.model));
    const Gain joint_gain = gain({held.back()}, options.seed);
    const auto parameters = found_parameters(e, s.model);
    for (std::size_t i = 0; i < s.model.terms().size(); ++i) {
      const Term& t = s.model.terms()[i];
      Effect effect = t.effect;
      t.fill(effect, s.model.coefficients(i));
      if (!t.named()) {
        d.unexplained.push_back({e.joint, t.unnamed, effect.number("order"), {}, effect.number("amplitude")});
        continue;
      }
      Cause cause{effect, parameters[i], s.p_values[i], joint_gain};
      cause.rms = rms((t.columns.matrix() * s.model.coefficients(i)).array());
      d.causes.push_back(std::move(cause));
      for (const Alternative& a : s.alternatives)
        if (a.term == i) d.alternatives.push_back({effect.type, a.effect.type, e.joint, ""});
    }
  }
  d.gain = gain(held, options.seed);
  d.verdict = all.empty()                                 ? Verdict::cannot_judge
              : !d.alternatives.empty()                   ? Verdict::ambiguous
              : d.causes.empty() && d.unexplained.empty() ? Verdict::nothing_wrong
              : d.causes.empty()                          ? Verdict::unexplained
              : d.unexplained.empty()                     ? Verdict::explained
                                                          : Verdict::partly_explained;
  return d;
}

}  // namespace qerr
