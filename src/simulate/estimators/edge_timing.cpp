#include <cmath>
#include <deque>
#include <limits>

#include "simulate/estimators/estimator.hpp"

namespace qerr {

namespace {

/// The last edges, over `span` counts, and whether all were crossed in the same direction.
class TimedEdges {
 public:
  TimedEdges(const EstimatorDesign& d, double counts_per_line)
      : clock_(d.numbers.at("clock")),
        timeout_(d.numbers.contains("timeout") ? d.numbers.at("timeout")
                                               : std::numeric_limits<double>::infinity()),
        span_(d.choices.at("edges") == "line" ? counts_per_line : 1) {}

  double operator()(const CounterSample& sample) {
    for (const Edge& e : sample.edges) {
      edges_.push_back({std::floor(e.time * clock_) / clock_, e.direction});
      if (static_cast<double>(edges_.size()) > span_ + 1) edges_.pop_front();
    }
    if (static_cast<double>(edges_.size()) < span_ + 1) return 0;
    const Edge &first = edges_.front(), &last = edges_.back();
    for (const Edge& e : edges_)
      if (e.direction != last.direction) return 0;
    const double since = sample.time - last.time;
    if (since > timeout_) return 0;
    const double lasted = std::max(last.time - first.time, 1 / clock_);
    return last.direction * span_ / std::max(lasted, since);
  }

 private:
  double clock_, timeout_, span_;
  std::deque<Edge> edges_;
};

}  // namespace

/// With t_a < t_b the last two edges, stamped, and s the direction of the last: s Delta/(t_b - t_a) if both
/// have the same direction, else 0; |v| at most Delta/(t - t_b). Stamps in one tick count as one tick apart.
EstimatorKind edge_timing_estimator() {
  return {"edge_timing",
          "one count (or a line) over the time between its edges; decays as the time without an edge grows",
          {clock_row(),
           key::choice("edges", "all|line",
                       "the last two, or a whole line apart, which unequal states do not change"),
           timeout_row()},
          [](const EstimatorDesign& d, const Counter& c) {
            return VelocityEstimate(TimedEdges(d, std::max(1.0, c.counts_per_line)));
          },
          true};
}

}  // namespace qerr
