#pragma once

#include <string>
#include <vector>

#include "qerr/filter/norms.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// A filter with derivative 1 among the estimators.
struct VelocityFilter {
  std::string name;
  Filter filter;
  Norms norms;
  std::vector<std::size_t> joints;  ///< that it passes; empty: all
};

/// Runs every filter and estimator on the encoders' counts along a motion, and compares each estimate of a
/// joint's velocity with the true one.
///
/// The counts are those of `simulate`, with all effects; the edges are those of the disc, with the effects of
/// stages `disc` and `line` (estimators/estimator.hpp). A joint's velocity is the coupling times those of the
/// encoders. A filter of a lower rate is judged at its own samples.
///
/// The delay tau minimizes the mean square of v^(t) - v(t - tau), by Gauss and Newton from 0.
/// @param settling  initial part that does not count [s]
/// @throws Error (input; key `motion.sample_rate`) if a filter's rate does not divide that of the motion
std::vector<EstimatedVelocity> compare_velocities(const OperationalModel&, const std::vector<VelocityFilter>&,
                                                  const std::vector<EstimatorDesign>&, const Motion&,
                                                  const std::vector<Effect>&, double settling,
                                                  const SimulationOptions&);

}  // namespace qerr
