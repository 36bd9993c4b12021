#pragma once

#include <optional>
#include <span>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/effect/share.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

/// Motion of the independent joints q, and of the encoder coordinates C^-1 q.
struct RobotUsage {
  std::vector<Usage> joints, encoders;
};

/// Usage derived from the joints' ranges and the URDF's <limit velocity effort>: positions uniform over the
/// ranges, velocity and effort uniform over -limit .. limit (rms limit/sqrt(3)). Quantities without a limit,
/// and times, are unknown.
/// @param ranges  one per independent joint; an infinite range leaves the position unknown [rad or m]
RobotUsage usage_from_limits(const OperationalModel&, const std::vector<Limits>& ranges);

/// Spread of equally probable samples. @pre not empty
Spread spread_of(std::span<const double> samples);

/// Error that one effect of the spec adds, and its joint.
struct EffectShare {
  Effect effect;
  std::size_t joint = 0;       ///< index of its independent joint
  std::optional<Share> share;  ///< empty: the usage does not have `effect_kind(type).need`
  bool included = false;       ///< whether it is in the bounds: known, and not only of a log or a reference
};

/// Shares of all effects, in the order given.
///
/// Effects act in the order of `Stage`: the position range of an effect is widened by the worst case of the
/// effects before it.
/// @throws std::out_of_range for an effect of a joint that is not in the chain
std::vector<EffectShare> effect_shares(const OperationalModel&, const std::vector<Effect>&,
                                       const RobotUsage&);

/// sigma of a filtered error over sigma of the error itself, from the spectrum of its share.
///
/// - white: ||H||_2
/// - constant: |H(1)|
/// - motion: |H(e^{j w T})| at the mean angular frequency w of the quantity that the error is proportional to
/// - reversals: square wave of the motion's frequency, sqrt(sum_{m odd} (8/(pi m)^2) |H(e^{j m w T})|^2)
/// - travel: sqrt(mean over the speeds v of |H(e^{j k v T})|^2) for every wave number k; assumes a constant
///   speed over the filter's memory
///
/// ||H||_2 where w or v is unknown.
double sigma_ratio(const Filter&, const Norms&, const Share&, const Usage&);

/// Error sources of the effects for `operational_error`, with their sigma ratios of the filters. Shares that
/// are not included or zero are skipped.
/// @param norms  one per filter
std::vector<ErrorSource> error_sources(const OperationalModel&, const std::vector<EffectShare>&,
                                       const RobotUsage&, const std::vector<Filter>&,
                                       const std::vector<Norms>& norms);

}  // namespace qerr
