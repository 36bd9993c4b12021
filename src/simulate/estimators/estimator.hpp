#pragma once

#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "qerr/core/parameter.hpp"
#include "qerr/simulate/simulate.hpp"
#include "simulate/edges.hpp"

namespace qerr {

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
