#include "qerr/design/requirement.hpp"

namespace qerr {

RequirementResult evaluate(const Requirement& r, const Workspace& w) {
  using Bound = Requirement::Bound;
  const auto& position = w.coordinates[r.coordinate];
  const Statistic* statistic = nullptr;
  if (r.filter >= 0) {
    const DerivativeStatistics& d = w.derivatives[static_cast<std::size_t>(r.filter)][r.coordinate];
    if (r.bound == Bound::sigma_in_motion && !d.sigma_in_motion)
      throw Error(
          Fault{r.place, "requirements", "sigma in motion is not computed", "'" + r.quantity + "'", ""});
    if (r.bound == Bound::sigma && !d.sigma)
      throw Error(
          Fault{r.place, "requirements",
                "cannot be decided: what an effect of the spec, or the accuracy of an encoder, adds behind a "
                "filter is not known",
                "'" + r.quantity + "'",
                "add `motion:`, state effects in place of `accuracy`, or ask for worst_case"});
    statistic = r.bound == Bound::sigma             ? &*d.sigma
                : r.bound == Bound::sigma_in_motion ? &*d.sigma_in_motion
                                                    : &d.worst_case;
  } else if (r.bound == Bound::worst_case_rigorous) {
    statistic = &position.worst_case_rigorous;
  } else {
    statistic = r.bound == Bound::sigma ? &position.sigma : &position.worst_case;
  }
  const double value = statistic->*r.value;
  return {value, value <= r.at_most};
}

}  // namespace qerr
