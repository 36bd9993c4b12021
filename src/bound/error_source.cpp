#include "qerr/bound/error_source.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

bool sigma_is_known(const std::vector<ErrorSource>& sources, std::size_t filter) {
  return std::none_of(sources.begin(), sources.end(), [&](const ErrorSource& s) {
    return filter < s.sigma_ratios.size() && std::isnan(s.sigma_ratios[filter]);
  });
}

Eigen::VectorXd sigma_ratios(const std::vector<ErrorSource>& sources, std::size_t filter, double h2) {
  Eigen::VectorXd ratios = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(sources.size()), h2);
  for (std::size_t s = 0; s < sources.size(); ++s)
    if (filter < sources[s].sigma_ratios.size()) {
      const double ratio = sources[s].sigma_ratios[filter];
      ratios[static_cast<Eigen::Index>(s)] = std::isnan(ratio) ? 0 : ratio;
    }
  return ratios;
}

}  // namespace qerr
