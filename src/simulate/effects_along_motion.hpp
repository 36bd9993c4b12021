#pragma once

#include <vector>

#include "qerr/bound/effect_shares.hpp"
#include "qerr/bound/independent_error.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/filter/filter.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// What effects that are not random add along a motion: their signal path without the rounding to counts,
/// then exact kinematics, then the filters, sample by sample at the rate of each filter. As in a simulation,
/// a filter starts in the steady state of the first error, and samples before `settling` do not count.
///
/// Instead of being rounded, a position is shifted by what the effects change in the mean rounding error over
/// the position of the encoder's zero. Peaks are those of this signal: at single positions of the zero an
/// effect that depends on the position differs from them (`change_with_zero`), and one that depends
/// on the place within a line or on the count itself is none of this signal's.
/// @param settling  initial part that is excluded [s]
ErrorAlongMotion effects_along_motion(const OperationalModel&, const std::vector<Effect>&, const Motion&,
                                      const std::vector<Filter>&, double settling);

/// Error that one effect adds alone, at its encoder's coordinate [rad or m]: a signal of one row.
SignalMoments effect_along_motion(const OperationalModel&, const Effect&, const Motion&, double settling);

/// Largest change of the error that effects add at an encoder's coordinate where the zeros of the encoders
/// move by half a count, the range of all zeros: at its ends, since it changes steadily over so short a
/// distance [rad or m].
double change_with_zero(const OperationalModel&, const std::vector<Effect>&, std::size_t encoder,
                        const Motion&, double settling);

/// Usage of joints and encoders by a motion: positions and velocities at its samples, and efforts by inverse
/// dynamics if the robot has masses. Means are over the samples after `motion.settling`, ranges over all. At
/// most 1e5 samples (1e4 for efforts), evenly spaced over the motion, are evaluated. Ranges of positions and
/// velocities include a bound on their peaks between the samples, and positions half a count for the unknown
/// zero of the encoder; those of efforts do not.
/// @param margin  time before and after the motion that the ranges include, for delayed samples [s]
RobotUsage usage_in_motion(const OperationalModel&, const Motion&, double margin = 0);

}  // namespace qerr
