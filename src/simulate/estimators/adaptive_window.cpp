#include <cmath>
#include <deque>

#include "simulate/estimators/estimator.hpp"

namespace qerr {

namespace {

class LongestLine {
 public:
  LongestLine(const EstimatorDesign& d, double period)
      : longest_(static_cast<std::size_t>(d.numbers.at("longest"))),
        band_(d.numbers.at("band") * (1 + 1e-9)),  // counts: a sample on the band is within it
        fits_(d.choices.at("fit") == "line"),
        period_(period) {}

  double operator()(const CounterSample& sample) {
    counts_.push_front(sample.count);
    if (counts_.size() > longest_ + 1) counts_.pop_back();
    if (counts_.size() < 2) return 0;
    std::size_t n = 1;
    while (n + 1 < counts_.size() && is_straight(n + 1)) ++n;
    return fits_ ? fitted_slope(n) : (counts_[0] - counts_[n]) / (static_cast<double>(n) * period_);
  }

 private:
  bool is_straight(std::size_t n) const {
    const double slope = (counts_[n] - counts_[0]) / static_cast<double>(n);
    for (std::size_t i = 1; i < n; ++i)
      if (std::abs(counts_[0] + slope * static_cast<double>(i) - counts_[i]) > band_) return false;
    return true;
  }

  double fitted_slope(std::size_t n) const {
    const double middle = 0.5 * static_cast<double>(n);
    double products = 0, squares = 0;
    for (std::size_t i = 0; i <= n; ++i) {
      const double at = middle - static_cast<double>(i);
      products += at * counts_[i];
      squares += at * at;
    }
    return products / (squares * period_);
  }

  std::size_t longest_;
  double band_;
  bool fits_;
  double period_;
  std::deque<double> counts_;  // the newest first
};

}  // namespace

/// n grows from 1 as long as the line through x_(k-n) and x_k passes within the band of all samples between;
/// then (x_k - x_(k-n))/(n T), or the slope of the line of least squares (Janabi-Sharifi, Hayward, Chen, IEEE
/// Trans. CST 8(6), 2000).
EstimatorKind adaptive_window_estimator() {
  return {
      "adaptive_window",
      "the longest window in which a line fits all samples within a band",
      {key::integer("longest", "samples from the oldest to the newest").otherwise(16).within(1, 10000),
       key::number("band", "distance of the samples from the line, in counts").otherwise(1).from(0),
       key::choice("fit", "end|line", "through the ends, or least squares")},
      [](const EstimatorDesign& d, const Counter& c) { return VelocityEstimate(LongestLine(d, c.period)); }};
}

}  // namespace qerr
