#pragma once

#include <optional>
#include <vector>

#include "diagnose/inference/explanation.hpp"
#include "diagnose/record/sampling.hpp"

namespace qerr {

/// The effects of the named terms, with their parameters.
std::vector<Effect> named_effects(const Explanation&);

/// Mean squares of one encoder's readings less the path, and of the simulated ones [rad^2 or m^2].
struct SimulatedReadings {
  double measured = 0, simulated = 0;
  double left = 0;  ///< mean square of the readings less the simulated positions
};

/// The named effects of a model, simulated along the record and rounded.
SimulatedReadings simulated_readings(const Sampling&, const Explanation&);

/// Rms of the readings less their rounding's mean, the simulation and what terms without a name add [rad or
/// m].
double left_by_simulation(const Sampling&, const Explanation&);

/// Whether the simulation leaves as much as the model says, and that as much as quantization and the noise of
/// the reference alone, to a tenth.
bool is_reproduced(const Sampling&, const Explanation&);

/// The model fitted by simulation (Gauss-Newton): each term's columns are the derivatives of the simulation
/// by its coefficients, and their constant part is exact at the fit. Scale acts on what an offset has
/// displaced, and a delay of many rows is no multiple of the velocity: with these the linear terms leave
/// errors that others are then chosen to explain.
/// @param model  of named and other terms; fitted to the evidence of `sampling`
Explanation simulated_fit(const Sampling& sampling, const Explanation& model);

/// The term without which the fit is as good: p > 1e-4 of the likelihood ratio, in independent readings.
/// @param model  of simulated_fit
std::optional<std::size_t> needless_term(const Explanation& model);

}  // namespace qerr
