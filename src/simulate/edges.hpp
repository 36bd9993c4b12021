#pragma once

#include <functional>
#include <vector>

#include "qerr/effect/effect_kind.hpp"
#include "qerr/encoder/encoder.hpp"

namespace qerr {

/// One change of an encoder's count.
struct Edge {
  double time = 0;    ///< true instant [s]
  int direction = 1;  ///< of the count along the joint coordinate: 1 or -1
};

/// The coordinate of an encoder in time [rad or m], and its derivative.
struct EncoderPath {
  std::function<double(double time)> position, velocity;
  double step = 0;  ///< between two instants at which the velocity may change its sign once [s]
};

/// The edges of an encoder along its path, in the order of time: the instants at which the position that the
/// disc shows crosses (k - 1/2) Delta (k Delta with rounding down).
///
/// The disc's errors are the effects of stages `disc` and `line`. Turning points are found by bisection, so
/// that between two of them the position is monotone, and every crossing lies in a bracket, in which it is
/// found by the Illinois method to 1e-9 of the step.
/// @pre the disc's errors change by less than the position: edges do not coincide
class EdgeFinder {
 public:
  EdgeFinder(const Encoder&, std::vector<Action> disc, EncoderPath, double start);

  /// The edges behind the last call's instant up to this one. Valid until the next call.
  const std::vector<Edge>& until(double time);

 private:
  double shown(double time) const;
  void cross(double from, double to);
  double root(double from, double to, double threshold) const;

  double resolution_, below_;
  mutable std::vector<Action> disc_;
  EncoderPath path_;
  double now_, velocity_, tolerance_;
  std::vector<Edge> edges_;
};

/// The effects of an encoder's disc and lines, in the order of their stages.
std::vector<Action> disc_actions(const std::vector<Effect>&, const Encoder&, const std::string& joint);

}  // namespace qerr
