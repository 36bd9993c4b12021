#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "qerr/bound/figure.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

/// The maximum of a figure over a box of joint coordinates lies between `lower` and `upper`.
struct ProvenMaximum {
  double lower = 0;       ///< the figure at `at`, by the same functions as in `workspace`
  double upper = 0;       ///< never exceeded in the box, rounding included; +inf: no bound is known
  Eigen::VectorXd at;     ///< independent joints [rad or m]
  double wanted_gap = 0;  ///< at which the proof ends

  /// upper/lower - 1; 0 of a figure that is zero everywhere.
  double gap() const;
};

struct ProofOptions {
  double gap = 0.01;     ///< wanted; work that grows too much ends with a wider one
  unsigned threads = 0;  ///< 0: one per core; the result does not depend on it
  /// Figures that are proven, of all.
  std::function<void(std::uint64_t done, std::uint64_t total)> progress = {};
  /// As in WorkspaceOptions; needed for sigma_in_motion.
  std::vector<Eigen::VectorXd> noise_in_motion = {};
  /// Configurations from which the search for the maximum also starts, such as those of sampled maxima.
  std::vector<Eigen::VectorXd> starts = {};
  /// [figure]: a limit whose verdict is wanted, infinite without one; empty: none. Where it is far away, a
  /// gap as wide as the part `of_distance` of the distance between it and `lower` will do, but at most 1.
  std::vector<double> limits = {};
  /// 1: only the verdict counts. The gap may be of any width, and where `lower` exceeds the limit there is no
  /// proof (`upper` is infinite).
  double of_distance = 1;
};

/// Proven maxima of figures over the box of the joint ranges, in the order of `figures`.
///
/// `lower`: the largest of 65536 Sobol points and `starts`, each improved joint by joint: along one revolute
/// joint every entry of J is a + b cos q + c sin q, so that a worst case is a sum of magnitudes of such terms
/// and a variance a trigonometric polynomial of degree 2, whose maxima are known. Joints that move several
/// axes (mimics) are searched along their range.
///
/// `upper`: the lower of two bounds. Dynamic programming along the chain (chain_bound.hpp), where it applies;
/// and branch and bound over boxes of joint coordinates (box_bound.hpp) for every model without Euler
/// angles. The number of boxes and the finest grid depend on `gap` only, so that the result does not depend
/// on time; the gap that is left may be wider than the one wanted. Roll, pitch and yaw have no upper bound
/// here: +inf.
///
/// What holds behind a filter: the worst case has half widths times ||H||_1 and means times |H(1)|, sigma of
/// each source its own ratio (derivative_error.hpp); where nothing but encoders that round to nearest errs,
/// this is the position's times the norm. `upper` of sigma includes the error of ||H||_2. Errors along a
/// motion are constants. The rigorous worst case adds the largest linearization remainder over the box.
/// @param ranges  one per independent joint [rad or m]; an infinite one of a joint that turns stands for all
/// angles
/// @throws Error (input; key `requirements`) if sigma behind a filter, or in motion, is not known
std::vector<ProvenMaximum> proven_maxima(const OperationalModel&, const std::vector<Norms>& filters,
                                         const std::vector<Limits>& ranges,
                                         const std::vector<Figure>& figures, const ProofOptions& = {});

/// Sets `lower` to a value that is reached.
/// @throws std::logic_error if it contradicts the proof: exceeds `upper` by more than 1e-9 of it
void set_reached(ProvenMaximum&, double value);

}  // namespace qerr
