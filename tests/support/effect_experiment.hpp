#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "qerr/bound/effect_shares.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/simulate/simulate.hpp"
#include "simulate/along_motion.hpp"
#include "support/random_chain.hpp"

/// Robots, motions and effects for tests of the effects' contributions to the bounds.
namespace qerr::testing {

inline OperationalModel model_of(const Chain& chain, const Transmission& transmission) {
  return {chain, transmission, {Coordinate::x, Coordinate::y, Coordinate::z}, {}};
}

/// One revolute joint, 0.7 m from the tip, with a quadrature encoder of 2000 counts behind a gear of 10.
inline OperationalModel one_joint() {
  ChainJoint joint;
  joint.name = "elbow";
  Chain chain;
  chain.joints = {joint};
  chain.independent = {{"elbow", JointType::revolute, {}, true}};
  chain.tip_offset.translation() = Eigen::Vector3d(0.7, 0, 0);
  Encoder encoder;
  encoder.resolution = 2 * std::numbers::pi / 20000;
  encoder.shaft_ratio = 10;
  return model_of(chain, {{encoder}, Eigen::MatrixXd::Identity(1, 1)});
}

inline Motion random_motion(Dice& dice, std::size_t joints, double seconds = 6) {
  Motion motion{500, seconds, 0.0, {}, {}};
  for (std::size_t i = 0; i < joints; ++i)
    motion.joints.push_back({dice.between(-1, 1),
                             0,
                             {{dice.between(0.2, 1), dice.between(0.3, 1), dice.between(0, 6)},
                              {dice.between(0, 0.2), dice.between(1, 3), dice.between(0, 6)}},
                             {}});
  return motion;
}

/// An effect with random parameters of noticeable magnitude.
inline Effect random_effect(Dice& dice, const EffectKind& kind, const std::string& joint,
                            const Encoder& encoder) {
  Effect e{std::string(kind.name), joint, {}, {}};
  const double step = encoder.resolution;
  for (const Parameter& p : kind.parameters) {
    const std::string name(p.name);
    if (p.kind == Kind::choice) {
      const auto words = choices_of(p);
      e.choices[name] = words[dice.below(words.size())];
      continue;
    }
    const double sign = dice.chance(0.5) ? 1 : -1;
    double value = dice.between(0, 20 * step);  // amplitudes, gaps, widths, steps
    if (name == "offset" || (name == "amplitude" && p.least < 0)) value *= sign;
    if (name == "scale" || name == "rate") value = sign * dice.between(0, 1e-3);
    if (name == "phase") value = dice.between(-1.4, 1.4);
    if (name == "order") value = p.most == 1 ? 1 : dice.between(0.5, 60);
    if (name == "offset_sin" || name == "offset_cos" || name == "gain") value = dice.between(-0.1, 0.1);
    if (name == "clipping") value = dice.between(0.5, 1);
    if (name == "counts") value = std::round(dice.between(-50, 50));
    if (name == "time" || name == "time_constant") value = dice.between(0.1, 8);
    if (name == "factor") value = dice.chance(0.5) ? dice.between(-2, 3) : sign * std::exp2(dice.below(3));
    if (name == "compliance" || name == "coefficient") value = 0;  // no load and no temperature in these runs
    if (name == "delay") value = sign * dice.between(0, 0.03);
    if (name == "sigma") value = p.dimension == dimension::time ? dice.between(0, 5e-3) : value;
    if (name == "modulus") value = std::round(dice.between(0.1, 3) / step);
    e.numbers[name] = value;
  }
  return e;
}

inline bool is_gaussian(const Effect& e) { return e.type == "noise" || e.type == "timing_jitter"; }

/// Largest |estimate - true| of every joint over one simulated run.
inline Eigen::VectorXd largest_errors(const OperationalModel& model, const Motion& motion,
                                      const std::vector<Effect>& effects) {
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model.chain.independent.size()));
  SimulationOptions options;
  options.threads = 1;
  options.visit = [&](const Reading& r) { largest = largest.cwiseMax((r.estimate - r.joint).cwiseAbs()); };
  simulate(model, {}, {}, motion, effects, options);
  return largest;
}

inline OperationalModel with_sources(OperationalModel model, const std::vector<Effect>& effects,
                                     const Motion& motion, const std::vector<Filter>& filters = {}) {
  const RobotUsage usage = usage_in_motion(model, motion);
  std::vector<Norms> all;
  for (const Filter& f : filters) all.push_back(norms(f));
  model.sources = error_sources(model, effect_shares(model, effects, usage), all);
  return model;
}

/// Relative tolerance for the rounding of sums.
inline constexpr double rounding = 1e-9;

}  // namespace qerr::testing
