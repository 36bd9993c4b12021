#include "diagnose/inference/selection.hpp"

#include <cmath>

#include "core/statistics.hpp"

namespace qerr {

double size_of(const Explanation& m, std::size_t term) {
  const Eigen::ArrayXd added = addition(m.terms()[term], m.coefficients(term));
  return m.terms()[term].constant ? std::abs(added.mean()) : standard_deviation(added);
}

double mean_square_residual(const Explanation& m, const Evidence& e) {
  return (e.measured - e.reference - m.addition()).square().mean();
}

Selection selection_of(const Sampling& sampling, const FoundCauses& found) {
  Selection s{Explanation(sampling.evidence), {}, {}, {}};
  for (const ChosenTerm& c : found.chosen) {
    s.model.add(c.candidate.over(sampling));
    s.p_values.push_back(c.p_value);
    s.lost.push_back(c.lost);
  }
  for (const Replacement& r : found.replacements) s.alternatives.push_back({r.instead_of, r.effect});
  if (!found.chosen.empty()) s.model.fit();
  return s;
}

}  // namespace qerr
