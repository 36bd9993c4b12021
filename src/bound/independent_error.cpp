#include "qerr/bound/independent_error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace qerr {

std::vector<IndependentError> independent_errors(const Transmission& t,
                                                 const std::vector<IndependentError>& others) {
  std::vector<IndependentError> errors;
  for (const Encoder& encoder : t.encoders)
    errors.push_back({.where = IndependentError::Where::encoder,
                      .owner = errors.size(),
                      .mean = mean_error(encoder),
                      .half_width = 0.5 * encoder.resolution,
                      .sigma = encoder.resolution / std::sqrt(12.0),
                      .in_counts = true});
  errors.insert(errors.end(), others.begin(), others.end());
  return errors;
}

Eigen::VectorXd moved_joints(const Transmission& t, const IndependentError& e) {
  const auto i = static_cast<Eigen::Index>(e.owner);
  if (e.where == IndependentError::Where::encoder) return t.coupling.col(i);
  return Eigen::VectorXd::Unit(std::ssize(t.encoders), i);
}

std::vector<IndependentError> accuracy_sources(const std::vector<Encoder>& encoders,
                                               const std::vector<SigmaRatios>& of_encoders,
                                               const std::vector<SigmaRatios>& of_gears) {
  std::vector<IndependentError> sources;
  const auto add = [&](std::size_t encoder, double bound, const std::vector<SigmaRatios>& ratios) {
    if (!(bound > 0)) return;
    IndependentError source{IndependentError::Where::encoder, encoder};
    source.half_width = bound;
    source.sigma = bound / std::numbers::sqrt2;
    source.sigma_ratios = ratios[encoder].filters;
    source.loop_ratios = ratios[encoder].loops;
    sources.push_back(std::move(source));
  };
  for (std::size_t i = 0; i < encoders.size(); ++i) {
    add(i, encoders[i].accuracy, of_encoders);
    add(i, encoders[i].gear_accuracy, of_gears);
  }
  return sources;
}

bool sigma_is_known(const std::vector<IndependentError>& sources, std::size_t filter) {
  return std::ranges::none_of(sources, [&](const IndependentError& s) {
    return filter < s.sigma_ratios.size() && std::isnan(s.sigma_ratios[filter]);
  });
}

Eigen::VectorXd sigma_ratios(const std::vector<IndependentError>& sources, std::size_t filter, double h2,
                             bool beside_noise_in_motion) {
  Eigen::VectorXd ratios = Eigen::VectorXd::Constant(std::ssize(sources), h2);
  for (std::size_t s = 0; s < sources.size(); ++s) {
    double& ratio = ratios[s];
    if (filter < sources[s].sigma_ratios.size()) ratio = sources[s].sigma_ratios[filter];
    if (std::isnan(ratio) || (beside_noise_in_motion && sources[s].in_counts)) ratio = 0;
  }
  return ratios;
}

JointError joint_error(const Transmission& t, const std::vector<IndependentError>& sources,
                       const SignalMoments* along_motion) {
  const auto n = std::ssize(t.encoders);
  JointError e{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n), {}, {}};
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(n);
  for (const IndependentError& error : independent_errors(t, sources)) {
    if (error.where == IndependentError::Where::origin) continue;
    const Eigen::VectorXd column = moved_joints(t, error);
    e.mean += column * error.mean;
    e.half_width += column.cwiseAbs() * error.half_width;
    variance += (column * error.sigma).cwiseAbs2();
  }
  if (along_motion) {
    e.half_width += along_motion->peak;
    variance += along_motion->covariance.diagonal();
  }
  e.sigma = variance.cwiseSqrt();
  e.worst_case = e.half_width + e.mean.cwiseAbs();
  return e;
}

}  // namespace qerr
