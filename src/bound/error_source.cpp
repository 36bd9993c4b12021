#include "qerr/bound/error_source.hpp"

namespace qerr {

Eigen::VectorXd sigma_ratios(const std::vector<ErrorSource>& sources, std::size_t filter, double h2) {
  Eigen::VectorXd ratios = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(sources.size()), h2);
  for (std::size_t s = 0; s < sources.size(); ++s)
    if (filter < sources[s].sigma_ratios.size())
      ratios[static_cast<Eigen::Index>(s)] = sources[s].sigma_ratios[filter];
  return ratios;
}

}  // namespace qerr
