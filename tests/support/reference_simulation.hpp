#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "qerr/simulate/simulate.hpp"
#include "support/reference_filter.hpp"

/// `simulate` of one run, sample by sample, with the scalar functions: the reference for the kernels.
namespace qerr::testing {

inline Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& r) {
  return {std::atan2(r(2, 1), r(2, 2)), std::atan2(-r(2, 0), cosine_of_pitch(r)),
          std::atan2(r(1, 0), r(0, 0))};
}

inline Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& r) {
  const Eigen::Vector3d twice_sine{r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)};
  const double sine = 0.5 * twice_sine.norm(), angle = std::atan2(sine, 0.5 * (r.trace() - 1));
  return sine < 1e-300 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(twice_sine * (0.5 * angle / sine));
}

/// Estimate minus truth: positions, the rotation vector of R_hat R^T, differences of the Euler angles.
inline Eigen::VectorXd tip_error(const std::vector<Coordinate>& coordinates,
                                 const Eigen::Isometry3d& estimate, const Eigen::Isometry3d& truth,
                                 CoordinateFrame frame = CoordinateFrame::base) {
  Eigen::Matrix<double, 9, 1> all;
  all << estimate.translation() - truth.translation(),
      rotation_vector(estimate.linear() * truth.linear().transpose()),
      roll_pitch_yaw(estimate.linear()) - roll_pitch_yaw(truth.linear());
  if (frame == CoordinateFrame::tip)
    for (const Eigen::Index first : {0, 3})
      all.segment<3>(first) = truth.linear().transpose() * all.segment<3>(first).eval();
  for (Eigen::Index i = 6; i < 9; ++i) all[i] = std::remainder(all[i], 2 * std::numbers::pi);
  Eigen::VectorXd error(static_cast<Eigen::Index>(coordinates.size()));
  for (std::size_t i = 0; i < coordinates.size(); ++i)
    error[static_cast<Eigen::Index>(i)] = all[static_cast<Eigen::Index>(coordinates[i])];
  return error;
}

/// Statistics of one output: exact error, linear part, parts of the encoders.
struct ReferenceOutput {
  Eigen::ArrayXd mean, sigma, peak;
};

struct ReferenceRun {
  std::vector<ReferenceOutput> outputs;  ///< [0: position, then the filters]
  Eigen::ArrayXd rigorous;               ///< largest along the path
  Eigen::ArrayXd deviation;              ///< of the difference from the mean at the centre
  Eigen::ArrayXd path_sigma;             ///< root of the mean of sum (J C Delta)^2 / 12
};

/// @param settling  number of samples that are ignored at the start
inline ReferenceRun reference_run(const OperationalModel& model, const std::vector<Filter>& filters,
                                  const Motion& motion, const std::vector<Effect>& effects,
                                  const Sensing::Options& options, std::uint64_t settling) {
  const auto m = static_cast<Eigen::Index>(model.coordinates.size());
  const Eigen::VectorXd steps = resolutions(model.transmission);
  const Eigen::Index channels = m * (2 + steps.size());
  const auto samples = static_cast<std::uint64_t>(std::floor(motion.duration * motion.sample_rate + 0.5));
  const Eigen::ArrayXd center_mean = operational_error(model, center(motion)).mean.array();
  Sensing sensing(model, motion, effects, options);
  std::vector<ReferenceFilter> banks;
  for (const Filter& filter : filters) banks.emplace_back(filter, channels);
  std::vector<std::vector<Eigen::ArrayXd>> record(filters.size() + 1);
  ReferenceRun r;
  r.rigorous = r.deviation = r.path_sigma = Eigen::ArrayXd::Zero(m);
  for (std::uint64_t k = 0; k < samples; ++k) {
    const Reading& now = sensing.read(k);
    const OperationalError theory = operational_error(model, now.joint);
    r.rigorous = r.rigorous.max(theory.rigorous.array());
    r.deviation = r.deviation.max(theory.rigorous.array() - theory.mean.array().abs() +
                                  (theory.mean.array() - center_mean).abs());
    if (k >= settling) r.path_sigma += theory.weighted.rowwise().squaredNorm().array() / 12;
    Eigen::ArrayXd input(channels);
    const Eigen::MatrixXd parts =
        theory.weighted * (now.measured - now.encoder).cwiseQuotient(steps).asDiagonal();
    input << tip_error(model.coordinates, forward_kinematics(model.chain, now.estimate), now.tip, model.frame)
                 .array(),
        parts.rowwise().sum().array(), parts.reshaped().array();
    if (k >= settling) record[0].push_back(input);
    for (std::size_t f = 0; f < filters.size(); ++f) {
      if (k % static_cast<std::uint64_t>(std::round(motion.sample_rate / filters[f].sample_rate)) != 0)
        continue;
      if (k == 0) banks[f].settle(input);
      Eigen::ArrayXd signal = input;
      banks[f].step(signal);
      if (k >= settling) record[f + 1].push_back(signal);
    }
  }
  r.path_sigma = (r.path_sigma / static_cast<double>(samples - settling)).sqrt();
  for (const auto& values : record) {
    ReferenceOutput& o = r.outputs.emplace_back();
    o.mean = o.sigma = o.peak = Eigen::ArrayXd::Zero(channels);
    const auto n = static_cast<double>(values.size());
    for (const auto& v : values) o.mean += v / n, o.peak = o.peak.max(v.abs());
    for (const auto& v : values) o.sigma += (v - o.mean).square() / n;
    o.sigma = o.sigma.sqrt();
  }
  return r;
}

}  // namespace qerr::testing
