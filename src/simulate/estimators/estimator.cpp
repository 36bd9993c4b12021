#include "simulate/estimators/estimator.hpp"

#include <stdexcept>

namespace qerr {

const std::vector<EstimatorKind>& estimator_kinds() {
  static const std::vector<EstimatorKind> list{
#define QERR_ESTIMATOR(name) name##_estimator(),
#include "simulate/estimators/list.inc"
#undef QERR_ESTIMATOR
  };
  return list;
}

const EstimatorKind& estimator_kind(std::string_view name) {
  for (const EstimatorKind& kind : estimator_kinds())
    if (kind.name == name) return kind;
  throw std::out_of_range("no estimator kind " + std::string(name));
}

Parameter clock_row() {
  return {.name = "clock",
          .dimension = dimension::frequency,
          .meaning = "frequency of the timer that stamps the edges, down to a tick",
          .required = true,
          .least = 1e-3,
          .most = 1e15};
}

Parameter timeout_row() {
  return {.name = "timeout",
          .dimension = dimension::time,
          .meaning = "without an edge for so long the velocity is 0; default: never",
          .least = 0,
          .open_below = true};
}

}  // namespace qerr
