#include "qerr/input/spec.hpp"

#include <algorithm>

namespace qerr {

bool is_filtered(const NamedFilter& f, const Signal& s) {
  if (f.joints.empty()) return !is_closed(s);
  return s.kind && s.kind->joints && std::find(f.joints.begin(), f.joints.end(), s.index) != f.joints.end();
}

std::vector<Filter> designed_filters(const Spec& spec) {
  std::vector<Filter> filters;
  for (const NamedFilter& f : spec.filters) filters.push_back(f.filter);
  return filters;
}

std::vector<Norms> filter_norms(const Spec& spec) {
  std::vector<Norms> norms;
  for (const NamedFilter& f : spec.filters) norms.push_back(f.norms);
  return norms;
}

}  // namespace qerr
