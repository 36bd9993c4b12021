#pragma once

#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "effect/action_path.hpp"
#include "qerr/core/parameter.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/encoder/encoder.hpp"
#include "qerr/simulate/simulate.hpp"

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
  EdgeFinder(const Encoder&, ActionPath disc, EncoderPath, double start);

  /// The edges behind the last call's instant up to this one. Valid until the next call.
  const std::vector<Edge>& until(double time);

 private:
  double shown(double time) const;
  void cross(double from, double to);
  double root(double from, double to, double threshold) const;

  double resolution_, below_;
  ActionPath disc_;
  EncoderPath path_;
  double now_, velocity_, tolerance_;
  std::vector<Edge> edges_;
};

/// The effects of an encoder's disc and lines, in the order of their stages.
ActionPath disc_actions(const std::vector<Effect>&, const Encoder&, const std::string& joint);

/// What an estimator has at a sample: the count, and the edges since the sample before.
struct CounterSample {
  double time = 0;   ///< [s]
  double count = 0;  ///< an integer
  std::span<const Edge> edges;
};

/// Maps each sample, in order, to the velocity [counts/s]. Keeps a state: one a run and encoder.
using VelocityEstimate = std::function<double(const CounterSample&)>;

/// The counter that an estimator reads.
struct Counter {
  double resolution = 0;  ///< Delta [rad or m]
  double period = 0;      ///< between two samples [s]
  double counts_per_line = 4;
};

/// A row of the family of velocity estimators that are no linear filter: a file of this folder and a line in
/// list.inc.
struct EstimatorKind {
  std::string_view name;
  std::string_view summary;
  std::vector<Parameter> parameters;
  VelocityEstimate (*make)(const EstimatorDesign&, const Counter&);
  bool timed = false;  ///< takes the instants of edges, on its parameter `clock`
};

const std::vector<EstimatorKind>& estimator_kinds();

/// @throws std::out_of_range for a name that no row has; specs are checked when they are read
const EstimatorKind& estimator_kind(std::string_view name);

/// Parameter rows of several kinds.
Parameter clock_row();
Parameter timeout_row();

/// `value`, limited to a magnitude.
inline double limited(double value, double most) { return std::min(std::max(value, -most), most); }

#define QERR_ESTIMATOR(name) EstimatorKind name##_estimator();
#include "simulate/estimators/list.inc"
#undef QERR_ESTIMATOR

}  // namespace qerr
