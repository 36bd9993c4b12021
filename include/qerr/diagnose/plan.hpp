#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

/// An effect whose contribution to the readings is correlated with that of another one in a motion.
struct CorrelatedEffect {
  Effect effect;
  double correlation = 0;  ///< of both contributions, at the phases where it is largest
  /// Size of the other effect from which both are distinguished [SI]; infinite: at no size in this motion.
  double separable_from = std::numeric_limits<double>::infinity();
  std::string record;  ///< what to record to distinguish them

  bool inseparable() const { return separable_from == std::numeric_limits<double>::infinity(); }
};

/// Sizes from which a record of the motion shows one effect. They are values of its parameter [SI], for
/// periodic effects at the least favourable phase.
struct PlannedEffect {
  Effect effect;                                                  ///< with its fixed numbers and choices
  std::string parameter;                                          ///< whose sizes are given
  double detectable = std::numeric_limits<double>::infinity();    ///< as an error, perhaps of another effect
  double identifiable = std::numeric_limits<double>::infinity();  ///< as this effect and no other
  double counts_per_size = 0;  ///< largest contribution to a reading per unit of the parameter [counts]
  std::vector<CorrelatedEffect> correlated;

  double detectable_counts() const { return detectable * counts_per_size; }
  double identifiable_counts() const { return identifiable * counts_per_size; }
  bool has_inseparable() const {
    for (const CorrelatedEffect& c : correlated)
      if (c.inseparable()) return true;
    return false;
  }
};

/// An effect that no size makes detectable, and the column that the record lacks for it.
struct UndetectableEffect {
  std::string effect, required;
};

/// What a record of the motion shows at one encoder.
struct PlannedJoint {
  std::string joint;
  bool prismatic = false;
  bool moves = false;     ///< by a count or more; else no effect is listed
  double readings = 0;    ///< independent ones
  double resolution = 0;  ///< [rad or m]
  std::vector<PlannedEffect> effects;
  std::vector<UndetectableEffect> undetectable;
};

struct PlanOptions {
  double reference_noise = 0.05;   ///< of the reference sensor, standard deviation [counts], > 0
  double power = 0.95;             ///< probability with which an effect of the stated size is found
  double alpha = 0.01;             ///< false alarm probability at one encoder, over all candidates
  double least_amplitude = 0.1;    ///< rms contribution of an effect that is worth reporting [counts]
  Eigen::Index most_rows = 20000;  ///< evaluated, evenly over the motion; the others are counted as readings
  bool improve = true;             ///< search for a better motion
};

/// What `qerr diagnose` could find in a record of a motion, and a motion that shows more.
struct Plan {
  std::vector<PlannedJoint> joints;  ///< one per encoder, in chain order
  PlanOptions options;
  std::optional<Motion> better;             ///< of the same duration and rate; empty: none was found
  std::vector<std::size_t> changed;         ///< joints whose motion differs in it
  std::vector<PlannedJoint> joints_better;  ///< with the better motion
};

/// Predicts, before any data exist, which effects `diagnose` detects in a record of a motion, from which size
/// on, and which effects it distinguishes.
///
/// It is assumed that every joint has a reference with white noise, that the load is known if the URDF has
/// masses, and that no temperatures are recorded. A quantized reading has the Fisher information
///   I = integral over one count of sum_k (d P_k/dx)^2 / P_k, P_k = Phi((k + 1 - x)/s) - Phi((k - x)/s),
/// s the reference's noise [counts]; at s = 0.05 it is three times that of a uniform error of variance 1/12.
/// With X the contributions of the effects per unit of their parameters, an effect of size a in the direction
/// u is detectable if the noncentrality a^2 I u^T X^T X u reaches the value that passes the test of
/// `diagnose` with the given power, and if its rms is worth reporting. It is identifiable if, in addition,
/// its rms about the mean is worth reporting, and if its part that another effect cannot reproduce (X after
/// projection on that effect's columns) passes the test of an alternative with the same power. Two effects
/// are inseparable if one reproduces more than 96 % of the other's variance: `diagnose` then reports both as
/// alternatives, whatever their size.
///
/// Effects are compared in pairs, as in `diagnose`, not in combinations.
///
/// @param present  effects that the spec has: their random part is in the readings
/// @param motion   better motions keep its rate and its duration
Plan plan(const OperationalModel&, const std::vector<Effect>& present, const Motion&,
          const PlanOptions& = {});

}  // namespace qerr
