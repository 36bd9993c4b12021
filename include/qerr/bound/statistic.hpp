#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace qerr {

/// How a quantity is distributed over the configurations. Percentiles interpolate linearly between order
/// statistics.
struct Statistic {
  double min = 0, mean = 0, max = 0, p50 = 0, p95 = 0, p99 = 0;
  Eigen::VectorXd at_max;  ///< the first configuration that has the maximum, independent joints [rad or m]
};

/// Collects a quantity that is >= 0, possibly +inf, in the order in which it is fed; results depend on that
/// order alone.
///
/// Up to `exact_limit` values percentiles are exact. Beyond, values are counted in bins of relative width
/// 2^-12 (the leading bits of the double), memory stays constant, and percentiles are right to 1.3e-4
/// relative.
class Accumulator {
 public:
  static constexpr std::uint64_t exact_limit = std::uint64_t{1} << 20;

  explicit Accumulator(std::uint64_t expected);

  void add(double value, const Eigen::VectorXd& configuration);

  /// Adds what `later` has seen after what this one has seen.
  void append(const Accumulator& later);

  Statistic result() const;
  bool percentiles_are_exact() const { return bins_.empty(); }

 private:
  double percentile(double fraction) const;
  double order_statistic(std::uint64_t rank) const;

  std::uint64_t count_ = 0;
  double sum_ = 0, min_ = 0, max_ = 0;
  Eigen::VectorXd at_max_;
  mutable std::vector<double> values_;  ///< sorted on demand by result()
  std::vector<std::uint64_t> bins_;
};

}  // namespace qerr
