#pragma once

#include <optional>
#include <span>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

/// How the independent joints are used, and with them the coordinates C^-1 q of their encoders.
struct RobotUsage {
  std::vector<Usage> joints, encoders;
};

/// The usage that the joints' ranges and the URDF's <limit velocity effort> suggest: positions evenly spread
/// over the ranges, velocity and effort over -limit .. limit (rms limit/sqrt(3)). What no limit gives, and
/// any time, is not known.
/// @param ranges  one per independent joint; an unbounded one says nothing [rad or m]
RobotUsage usage_from_limits(const OperationalModel&, const std::vector<Limits>& ranges);

/// Spread of equally likely samples. @pre there is one
Spread spread_of(std::span<const double> samples);

/// What one effect of the spec adds, and where.
struct EffectShare {
  Effect effect;
  std::size_t joint = 0;       ///< index of its independent joint
  std::optional<Share> share;  ///< empty: the usage lacks what `effect_kind(type).need` says
  bool counts = false;         ///< known, and of the robot: not of a file or a reference alone
};

/// Shares of all effects, in the order given.
///
/// Effects act one after the other, in the order of `Stage`: one that multiplies the position meets what
/// those before it have added, so that the position it sees is widened by their worst case.
/// @throws std::out_of_range for an effect of a joint that the chain has not
std::vector<EffectShare> effect_shares(const OperationalModel&, const std::vector<Effect>&,
                                       const RobotUsage&);

/// sigma of an error behind a filter over its sigma before it, by how it comes and goes.
///
/// white: ||H||_2. constant: |H(1)|. motion: |H(e^{j w T})| at the mean angular frequency w of what it is
/// proportional to, as if that were one sine. reversals: the square wave that turns as often as the motion,
/// sqrt(sum_{m odd} (8/(pi m)^2) |H(e^{j m w
/// T})|^2). travel: sqrt(mean over the speeds v of |H(e^{j k v T})|^2) for every wave k, which is exact at
/// constant speed and otherwise takes the speed as constant over the filter's memory. Where the usage does
/// not know w or v all frequencies count alike, which is ||H||_2.
double passed_by(const Filter&, const Norms&, const Share&, const Usage&);

/// The sources of error that the effects are to `operational_error`, with their gains behind the filters.
/// Those that do not count, or have no size, are left out.
/// @param norms  one per filter
std::vector<ErrorSource> error_sources(const OperationalModel&, const std::vector<EffectShare>&,
                                       const RobotUsage&, const std::vector<Filter>&,
                                       const std::vector<Norms>& norms);

}  // namespace qerr
