#include "qerr/bound/error_source.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace qerr {

std::vector<ErrorSource> accuracy_sources(const std::vector<Encoder>& encoders, std::size_t filters) {
  std::vector<ErrorSource> sources;
  for (std::size_t i = 0; i < encoders.size(); ++i) {
    const double bound = encoders[i].accuracy;
    if (!(bound > 0)) continue;
    ErrorSource source{ErrorSource::Where::encoder, i};
    source.half_width = bound;
    source.sigma = bound / std::numbers::sqrt2;
    source.sigma_ratios.assign(filters, std::numeric_limits<double>::quiet_NaN());
    sources.push_back(std::move(source));
  }
  return sources;
}

bool sigma_is_known(const std::vector<ErrorSource>& sources, std::size_t filter) {
  return std::none_of(sources.begin(), sources.end(), [&](const ErrorSource& s) {
    return filter < s.sigma_ratios.size() && std::isnan(s.sigma_ratios[filter]);
  });
}

Eigen::VectorXd sigma_ratios(const std::vector<ErrorSource>& sources, std::size_t filter, double h2,
                             bool beside_noise_in_motion) {
  Eigen::VectorXd ratios = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(sources.size()), h2);
  for (std::size_t s = 0; s < sources.size(); ++s) {
    double& ratio = ratios[static_cast<Eigen::Index>(s)];
    if (filter < sources[s].sigma_ratios.size()) ratio = sources[s].sigma_ratios[filter];
    if (std::isnan(ratio) || (beside_noise_in_motion && sources[s].in_counts)) ratio = 0;
  }
  return ratios;
}

}  // namespace qerr
