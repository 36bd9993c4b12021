#include "qerr/input/spec.hpp"

namespace qerr {

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
