#pragma once

#include <cmath>

#include "diagnose/record/evidence.hpp"
#include "support/random_chain.hpp"

namespace qerr::testing {

/// Parameters of the random evidence of a joint.
struct EvidenceMix {
  Eigen::Index rows = 1000;
  bool ordered = true, rests = true, zero_known = true, down = false, random_sigma = false, effort = false;
  double noise = 0.05;  ///< of the reference [counts]
};

/// A joint that oscillates, with standstills on request, at 1 kHz.
inline Evidence random_evidence(Dice& dice, const EvidenceMix& mix) {
  Evidence e;
  e.joint = "arm";
  e.encoder = {dice.between(1e-5, 1e-3), mix.down ? Rounding::down : Rounding::nearest, mix.zero_known,
               dice.between(1, 100)};
  e.ordered = mix.ordered;
  const double step = e.step(), rate = dice.between(0.3, 3), size = dice.between(0.1, 1);
  const auto normal = [&] {
    double sum = 0;
    for (int i = 0; i < 12; ++i) sum += dice.between(-0.5, 0.5);
    return sum;
  };
  for (Eigen::ArrayXd* a : {&e.time, &e.reference, &e.measured, &e.path, &e.velocity, &e.direction})
    a->resize(mix.rows);
  if (mix.random_sigma) e.random_sigma.resize(mix.rows);
  if (mix.effort) e.effort.resize(mix.rows);
  double moved = 0;
  for (Eigen::Index k = 0; k < mix.rows; ++k) {
    const bool resting = mix.rests && (k / 200) % 3 == 1;
    if (!resting) moved += 1e-3;
    e.time[k] = mix.ordered ? 1e-3 * static_cast<double>(k) : static_cast<double>(k);
    e.path[k] = size * std::sin(rate * moved) + (resting ? 0 : 1e-3 * step * normal());
    e.velocity[k] = resting ? 0 : size * rate * std::cos(rate * moved);
    e.direction[k] = std::cos(rate * moved) < 0 ? -1 : 1;
    e.reference[k] = e.path[k] + mix.noise * step * normal();
    if (mix.random_sigma) e.random_sigma[k] = dice.between(0, 0.5) * step;
    if (mix.effort) e.effort[k] = std::cos(3 * rate * moved) + 0.1 * normal();
    e.measured[k] = quantize(e.encoder, e.path[k] + (mix.random_sigma ? e.random_sigma[k] * normal() : 0));
  }
  e.noise = mix.noise * step;
  e.path_noise = 0.2 * e.noise;
  return e;
}

}  // namespace qerr::testing
