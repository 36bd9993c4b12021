#include <cmath>
#include <deque>
#include <limits>
#include <optional>

#include "simulate/estimators/estimator.hpp"

namespace qerr {

namespace {

/// The edges of a window, and the last one before it.
class CountedEdges {
 public:
  explicit CountedEdges(const EstimatorDesign& d)
      : window_(d.numbers.at("window")),
        clock_(d.numbers.at("clock")),
        timeout_(d.numbers.contains("timeout") ? d.numbers.at("timeout")
                                               : std::numeric_limits<double>::infinity()) {}

  double operator()(const CounterSample& sample) {
    edges_.insert(edges_.end(), sample.edges.begin(), sample.edges.end());
    while (!edges_.empty() && edges_.front().time <= sample.time - window_) {
      before_ = stamped(edges_.front());
      edges_.pop_front();
    }
    if (edges_.empty()) {
      if (!before_) return velocity_ = 0;
      const double since = sample.time - *before_;
      return velocity_ = since > timeout_ ? 0 : limited(velocity_, 1 / since);
    }
    if (!before_) return velocity_ = 0;
    double counts = 0;
    for (const Edge& e : edges_) counts += e.direction;
    return velocity_ = counts / std::max(stamped(edges_.back()) - *before_, 1 / clock_);
  }

 private:
  double stamped(const Edge& e) const { return std::floor(e.time * clock_) / clock_; }

  double window_, clock_, timeout_, velocity_ = 0;
  std::deque<Edge> edges_;
  std::optional<double> before_;
};

}  // namespace

/// M/T: with m the signed number of edges in (t - W, t], t_m the last of them and t_0 the last one before,
/// stamped: m Delta/(t_m - t_0). Without an edge in the window the value of before, at most Delta/(t - t_0).
EstimatorKind count_and_time_estimator() {
  return {"count_and_time",
          "M/T: the counts of a window over the time from the last edge before it to its last edge",
          {key::number("window", "in which edges are counted", dimension::time).above(0).needed(),
           clock_row(), timeout_row()},
          [](const EstimatorDesign& d, const Counter&) { return VelocityEstimate(CountedEdges(d)); },
          true};
}

}  // namespace qerr
