#pragma once

#include <optional>
#include <span>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
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
  /// Without a motion: how often the joint turns round [1/s] if it goes from end to end of its range at half
  /// of its largest speed, the mean of uniform speeds. Empty: not known.
  std::optional<double> reversals = {};
  /// By what later effects of the encoder (scale, decoding) multiply the error.
  double multiplied = 1;
};

/// Shares of all effects, in the order given.
///
/// Effects act in the order of `Stage`: the position range of an effect is widened by the worst case of the
/// effects before it, and its mean square by those of them that are not white: `multiplied` carries these.
/// @throws std::out_of_range for an effect of a joint that is not in the chain
std::vector<EffectShare> effect_shares(const OperationalModel&, const std::vector<Effect>&,
                                       const RobotUsage&);

/// Error sources of the effects for `operational_error`, with their sigma ratios of the filters: ||H||_2 of
/// white errors, |H(1)| of constant ones, unknown (NaN) of those that the motion determines, except of errors
/// that only jump at reversals: a step g through a filter has the energy g^2 T sum s_k^2, s its step
/// response. Sigmas of white errors are multiplied by what follows them. Shares that are not included or zero
/// are skipped.
/// @param norms          one per filter
/// @param step_energies  [filter]: T sum s_k^2 [s^(1 - 2d)]; empty: not known
std::vector<IndependentError> error_sources(const OperationalModel&, const std::vector<EffectShare>&,
                                            const std::vector<Norms>& norms,
                                            const std::vector<double>& step_energies = {});

}  // namespace qerr
