#include "diagnose/verdict/verdict.hpp"

#include <algorithm>

namespace qerr {

namespace {

/// Whether an unidentified residual affects the verdict. If the causes of its joint explain more than 99 % of
/// the variance, it is only reported.
bool affects_verdict(const Unidentified& residual, const std::vector<Cause>& causes) {
  constexpr double worth = 0.1;
  return std::none_of(causes.begin(), causes.end(), [&](const Cause& c) {
    return c.effect.joint == residual.joint && residual.amplitude < worth * c.gain.rms_before &&
           c.gain.rms_after < worth * c.gain.rms_before;
  });
}

}  // namespace

Verdict verdict(const Diagnosis& d, bool judged) {
  const bool found = !d.causes.empty(), residual = !d.unexplained.empty();
  if (!judged && !found && !residual) return Verdict::cannot_judge;
  if (!found) return residual ? Verdict::unexplained : Verdict::nothing_wrong;
  if (!d.alternatives.empty()) return Verdict::ambiguous;
  const bool counting = std::any_of(d.unexplained.begin(), d.unexplained.end(),
                                    [&](const Unidentified& u) { return affects_verdict(u, d.causes); });
  return counting || (d.check && !d.check->agrees) ? Verdict::partly_explained : Verdict::explained;
}

}  // namespace qerr
