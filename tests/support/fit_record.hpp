#pragma once

#include <cmath>
#include <functional>
#include <numbers>

#include "diagnose/record/evidence.hpp"
#include "support/random_chain.hpp"

/// Small synthetic records of one encoder, in which the path is known.
namespace qerr::testing {

inline double normal_deviate(Dice& dice) {
  const double radius = std::sqrt(-2 * std::log(dice.between(1e-12, 1)));
  return radius * std::cos(2 * std::numbers::pi * dice.between(0, 1));
}

/// What the encoder adds to the angle at a row [counts].
using CountsAdded = std::function<double(Dice&, const Evidence&, Eigen::Index row)>;

struct FitSetting {
  const char* name;
  Rounding rounding = Rounding::nearest;
  bool zero_known = true, random = false, ordered = true;
  bool accelerations = false;
  double shaft_ratio = 7, counts_per_period = 4;
  Eigen::Index rows = 900;
};

inline Evidence record_of_fit(Dice& dice, const FitSetting& s, const CountsAdded& added) {
  Evidence e;
  e.joint = "arm";
  e.encoder = {1.5e-3, s.rounding, s.zero_known, s.shaft_ratio, s.counts_per_period};
  const double step = e.step();
  e.ordered = s.ordered;
  e.interval = s.ordered ? 4e-3 : 0;
  e.time = Eigen::ArrayXd::LinSpaced(s.rows, 0, 4e-3 * static_cast<double>(s.rows - 1));
  const double phase = dice.between(0, 6);
  e.path = 2.4 * (2.9 * e.time + phase).sin() + 0.1 * (7.7 * e.time + 1).cos();
  e.velocity = 2.4 * 2.9 * (2.9 * e.time + phase).cos() - 0.1 * 7.7 * (7.7 * e.time + 1).sin();
  if (s.accelerations) e.acceleration = -2.9 * 2.9 * 2.4 * (2.9 * e.time + phase).sin();
  e.direction = (e.velocity > 0).select(Eigen::ArrayXd::Ones(s.rows), -Eigen::ArrayXd::Ones(s.rows));
  e.effort = (1.7 * e.time + 0.3).sin();
  e.temperature = 3 * (1 - (-0.6 * e.time).exp());
  e.noise = 0.05 * step;
  e.path_noise = 0.02 * step;
  if (s.random) e.random_sigma.resize(s.rows);
  e.reference.resize(s.rows);
  e.measured.resize(s.rows);
  for (Eigen::Index k = 0; k < s.rows; ++k) {
    e.reference[k] = e.path[k] + e.noise * normal_deviate(dice);
    double seen = e.path[k] + step * added(dice, e, k);
    if (s.random) {
      e.random_sigma[k] = dice.between(0.1, 0.5) * step;
      seen += e.random_sigma[k] * normal_deviate(dice);
    }
    e.measured[k] = quantize(e.encoder, seen);
  }
  return e;
}

}  // namespace qerr::testing
