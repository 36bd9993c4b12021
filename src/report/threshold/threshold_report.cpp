#include <cmath>
#include <numbers>

#include "qerr/core/error.hpp"
#include "qerr/report/analysis.hpp"

namespace qerr {

namespace {

/// Largest entry of the position rows of J C over the configurations, encoder by encoder [m/rad or 1].
Eigen::VectorXd largest_arms(const Spec& spec, unsigned threads) {
  OperationalModel model = spec.model;
  model.coordinates = {Coordinate::x, Coordinate::y, Coordinate::z};
  model.lengths.clear();
  model.signals.clear();
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

/// What an encoder moves, in metres per radian (or metre) of it.
struct Moved {
  std::size_t joint = 0;
  double length = 0;    ///< [m]
  double coupling = 1;  ///< |C_ji|
  double travel = 0;    ///< [m/rad or 1]
};

/// The joint j that encoder i moves farthest: l |C_ji| at the distance l from a revolute joint, |C_ji| along
/// a prismatic one, for joint angles C * encoder angles.
Moved farthest_joint(const OperationalModel& model, Eigen::Index encoder, double length) {
  Moved best;
  for (std::size_t j = 0; j < model.chain.independent.size(); ++j) {
    const double factor = std::abs(model.transmission.coupling(static_cast<Eigen::Index>(j), encoder));
    const double travel = factor * (model.chain.independent[j].prismatic() ? 1.0 : length);
    if (travel > best.travel) best = {j, length, factor, travel};
  }
  return best;
}

}  // namespace

ThresholdRow threshold_row(const Spec& spec, unsigned threads) {
  ThresholdRow best;
  best.robot = spec.robot_name;
  best.sample_rate = sample_rate_of(spec);
  const Transmission& transmission = spec.model.transmission;
  const Eigen::VectorXd arms = spec.threshold_length ? Eigen::VectorXd() : largest_arms(spec, threads);
  for (std::size_t i = 0; i < spec.encoder_figures.size(); ++i) {
    const auto encoder = static_cast<Eigen::Index>(i);
    const Moved moved = spec.threshold_length ? farthest_joint(spec.model, encoder, *spec.threshold_length)
                                              : Moved{i, arms[encoder], 1, arms[encoder]};
    const double resolution = moved.travel * transmission.encoders[i].resolution;
    if (i > 0 && !(resolution > best.resolution)) continue;
    const IndependentJoint& joint = spec.model.chain.independent[moved.joint];
    best.joint = joint.name;
    best.counts_per_rev = spec.encoder_figures[i].counts_per_rev;
    best.gear_ratio = spec.encoder_figures[i].gear_ratio;
    best.coupling = moved.coupling;
    best.length = moved.length;
    best.resolution = resolution;
    best.resolution_as_printed = joint.prismatic() ? resolution : resolution / (2 * std::numbers::pi);
  }
  constexpr double rounding = 1e-12;  // [m/rad] of an arm whose tip is on the axis
  if (!spec.threshold_length && !(arms.maxCoeff() > rounding))
    throw Error({{spec.file, 1, 1},
                 "threshold.length",
                 "no joint moves the position of the tip: it has no threshold velocity",
                 "",
                 "add threshold: {length: 300 mm}, the distance of a point from the axis"});
  return best;
}

}  // namespace qerr
