#include "qerr/design/requirement.hpp"

#include <algorithm>

namespace qerr {

namespace {

Error undecided(const Requirement& r, const std::string& reason, const std::string& remedy) {
  return Error(r.place, "requirements", reason, "'" + r.quantity + "'", remedy);
}

Error unknown_sigma(const Requirement& r) {
  return undecided(r,
                   "sigma behind a filter is not known: it depends on the motion, of which nothing is stated",
                   "add `motion:`, or velocity to the joints' <limit> in the URDF; or ask for worst_case or "
                   "sigma_quantization");
}

const Statistic& known_statistic(const Requirement& r, const Workspace& w) {
  if (const Statistic* s = statistic_of(w, r)) return *s;
  if (r.bound == Bound::sigma_in_motion) throw undecided(r, "sigma in motion is not computed", "");
  const Statistic* all = statistic_of(w, {r.signal, r.filter, Bound::sigma});  // nothing but quantization
  if (!all) throw unknown_sigma(r);
  return *all;
}

}  // namespace

RequirementResult evaluate(const Requirement& r, const Workspace& w, const std::vector<Filter>& filters,
                           const std::vector<Norms>& norms) {
  if (r.proven) throw undecided(r, "a proven maximum is no statistic of the sample", "");
  RequirementResult result;
  if (r.figure) {
    const auto f = static_cast<std::size_t>(r.filter);
    const std::optional<double> value = r.figure->value(filters[f], norms[f]);
    if (!value)
      throw undecided(r, "the filter has no " + std::string(r.figure->name),
                      "see `qerr filter`; ask for another figure");
    result.value = *value;
  } else {
    const Statistic& statistic = known_statistic(r, w);
    result.value = statistic.*r.value;
    result.at_max = statistic.at_max;
  }
  result.met = r.met_by(result.value);
  return result;
}

RequirementResult evaluate(const Requirement& r, double value) {
  return {.value = value, .met = r.met_by(value)};
}

Figure proven_figure(const Requirement& r, const OperationalModel& model) {
  if (r.filter >= 0 && is_sigma(r.bound) && r.bound != Bound::sigma_quantization &&
      !sigma_is_known(model.sources, r.filter))
    throw unknown_sigma(r);
  return r;
}

RequirementResult evaluate(const Requirement& r, const ProvenMaximum& proven) {
  RequirementResult result;
  result.proven = proven;
  result.value = r.at_least ? proven.lower : proven.upper;
  result.at_max = proven.at;
  result.met = r.met_by(result.value);
  result.undecided = !result.met && (r.at_least ? proven.upper >= r.limit : proven.lower <= r.limit);
  return result;
}

double deciding_gap(const Requirement& r, const ProvenMaximum& proven, double gap) {
  constexpr double finest = 0.1;
  return proven.lower > 0 ? std::clamp(r.limit / proven.lower - 1, finest * gap, gap) : finest * gap;
}

}  // namespace qerr
