#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/simulate/motion.hpp"

namespace qerr {

/// An effect that a motion shows alike.
struct Rival {
  Effect effect;
  double correlation = 0;  ///< of what both add, at the phase where they are most alike
  double size = std::numeric_limits<double>::infinity();  ///< from which on they are told apart [SI];
                                                          ///< infinite: never in this motion
  std::string record;                                     ///< what tells them apart

  bool twin() const { return size == std::numeric_limits<double>::infinity(); }
};

/// What a record of the motion would say of one effect. Sizes are of its parameter [SI]; of periodic ones at
/// the phase that is hardest to see.
struct PlannedEffect {
  Effect effect;                                           ///< with its fixed numbers and choices
  std::string parameter;                                   ///< whose size is meant
  double seen = std::numeric_limits<double>::infinity();   ///< smallest that shows, if under another name;
                                                           ///< infinite: none
  double named = std::numeric_limits<double>::infinity();  ///< and that nothing else could stand for
  double counts_per_size = 0;  ///< largest that a size of 1 adds to a reading in this motion [counts]
  std::vector<Rival> rivals;

  double seen_counts() const { return seen * counts_per_size; }
  double named_counts() const { return named * counts_per_size; }
  bool has_twin() const {
    for (const Rival& r : rivals)
      if (r.twin()) return true;
    return false;
  }
};

/// What the record lacks to show an effect at all.
struct Unseen {
  std::string effect, needs;
};

/// What a motion can say of one encoder.
struct PlannedJoint {
  std::string joint;
  bool prismatic = false;
  bool moves = false;     ///< by a count at least; else nothing can be said
  double readings = 0;    ///< that do not say the same
  double resolution = 0;  ///< [rad or m]
  std::vector<PlannedEffect> effects;
  std::vector<Unseen> unseen;
};

struct PlanOptions {
  double reference_noise = 0.05;   ///< of the better sensor, standard deviation [counts], > 0
  double power = 0.95;             ///< probability with which an effect of the stated size is found
  double alpha = 0.01;             ///< of a false name at one encoder, over all candidates
  double least_amplitude = 0.05;   ///< rms of what an effect adds that is worth a name [counts]
  Eigen::Index most_rows = 20000;  ///< of the motion, evenly; more are counted, but not looked at
  bool improve = true;             ///< look for a better motion
};

/// What `qerr diagnose` could find in a record of a motion, and which motion would show more.
struct Plan {
  std::vector<PlannedJoint> joints;  ///< one per encoder, in chain order
  PlanOptions options;
  std::optional<Motion> better;      ///< of the same length and rate; empty: none of those tried is better
  std::vector<std::size_t> changed;  ///< joints that move otherwise in it
  std::vector<PlannedJoint> joints_better;  ///< what it can say
};

/// Before any data exist: which effects a motion lets `diagnose` detect, from which size on, and tell apart.
///
/// Every joint is taken to have a reference with white noise; the load is known where the URDF has masses; no
/// temperatures are recorded. A reading whose edges are known has the information
///   I = integral over one count of sum_k (d P_k/dx)^2 / P_k, P_k = Phi((k + 1 - x)/s) - Phi((k - x)/s),
/// s the reference's noise [counts]: at s = 0.05 three times that of a uniform error of variance 1/12. With
/// the columns X that the effects add per unit, a size a along u is seen when a^2 I u^T X^T X u reaches the
/// noncentrality that passes the test of `diagnose` with the power asked for, and its rms is worth a name. It
/// is named when its rms about its mean is that too, and what another effect cannot make of it (X beyond that
/// one's columns) does as much for the test of an alternative. An effect of which another makes more than 96
/// % of the variance is its twin: `diagnose` takes no sides between them, whatever their size.
///
/// Each other effect is tried alone, as `diagnose` does, not in combinations.
///
/// @param present  effects that the spec has: their noise is in the readings
/// @param motion   of which better ones keep the rate and the duration
Plan plan(const OperationalModel&, const std::vector<Effect>& present, const Motion&,
          const PlanOptions& = {});

}  // namespace qerr
