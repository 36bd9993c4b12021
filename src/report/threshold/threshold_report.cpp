#include <cmath>
#include <numbers>

#include "qerr/core/error.hpp"
#include "qerr/report/analysis.hpp"

namespace qerr {

namespace {

/// Largest |dp/dq_i| over the configurations, joint by joint [m/rad or 1].
Eigen::VectorXd largest_arms(const Spec& spec, unsigned threads) {
  OperationalModel model = spec.model;
  model.coordinates = {Coordinate::x, Coordinate::y, Coordinate::z};
  WorkspaceOptions options;
  options.threads = threads;
  return workspace(model, {}, spec.configurations, options).largest_arms;
}

double sample_rate_of(const Spec& spec) {
  for (const NamedFilter& f : spec.filters)
    if (f.filter.derivative > 0) return f.filter.sample_rate;
  throw Error({{spec.file, 1, 1},
               "filters",
               "a threshold velocity needs the sample rate of a derivative filter",
               "",
               "add filters: {velocity: {derivative: 1, sample_rate: 1 kHz}}"});
}

}  // namespace

ThresholdRow threshold_row(const Spec& spec, unsigned threads) {
  ThresholdRow best;
  best.robot = spec.robot_name;
  best.sample_rate = sample_rate_of(spec);
  const Eigen::VectorXd arms = spec.threshold_length ? Eigen::VectorXd() : largest_arms(spec, threads);
  for (std::size_t i = 0; i < spec.encoder_figures.size(); ++i) {
    const IndependentJoint& joint = spec.model.chain.independent[i];
    // A prismatic joint moves the tip by as much as itself, whatever the length.
    const double length = spec.threshold_length ? *spec.threshold_length : arms[static_cast<Eigen::Index>(i)];
    const double arm = joint.prismatic() && spec.threshold_length ? 1.0 : length;
    const double resolution = arm * spec.model.transmission.encoders[i].resolution;
    if (i > 0 && !(resolution > best.resolution)) continue;
    best.joint = joint.name;
    best.counts_per_rev = spec.encoder_figures[i].counts_per_rev;
    best.gear_ratio = spec.encoder_figures[i].gear_ratio;
    best.length = length;
    best.resolution = resolution;
    best.resolution_as_printed = joint.prismatic() ? resolution : resolution / (2 * std::numbers::pi);
  }
  return best;
}

}  // namespace qerr
