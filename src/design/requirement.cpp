#include "qerr/design/requirement.hpp"

namespace qerr {

double value_of(const Statistic& s, Requirement::Stat stat) {
  switch (stat) {
    case Requirement::Stat::min:
      return s.min;
    case Requirement::Stat::mean:
      return s.mean;
    case Requirement::Stat::max:
      return s.max;
    case Requirement::Stat::p50:
      return s.p50;
    case Requirement::Stat::p95:
      return s.p95;
    case Requirement::Stat::p99:
      return s.p99;
  }
  return s.max;
}

RequirementResult evaluate(const Requirement& r, const Workspace& w) {
  using Bound = Requirement::Bound;
  const auto& position = w.coordinates[r.coordinate];
  const Statistic* statistic = nullptr;
  if (r.filter >= 0) {
    const DerivativeStatistics& d = w.derivatives[static_cast<std::size_t>(r.filter)][r.coordinate];
    if (r.bound == Bound::sigma_in_motion && !d.sigma_in_motion)
      throw Error(Fault{r.place, "requirements", "sigma in motion is not known", "'" + r.quantity + "'", ""});
    statistic = r.bound == Bound::sigma             ? &d.sigma
                : r.bound == Bound::sigma_in_motion ? &*d.sigma_in_motion
                                                    : &d.worst_case;
  } else if (r.bound == Bound::worst_case_rigorous) {
    statistic = &position.worst_case_rigorous;
  } else {
    statistic = r.bound == Bound::sigma ? &position.sigma : &position.worst_case;
  }
  const double value = value_of(*statistic, r.stat);
  return {value, value <= r.at_most};
}

}  // namespace qerr
