#include "diagnose/inference/remainder.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/statistics.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index parts = 12, fewest = 40;  ///< of the rows, sorted by position or time; rows per part

/// Share of the excess of squares that the part with the most has.
double largest_share(const Eigen::ArrayXd& excess, const Eigen::ArrayXd& along) {
  const Eigen::Index n = excess.size();
  if (n < parts * fewest) return 0;
  const std::vector<Eigen::Index> order = ascending_rows(along);
  double most = 0;
  for (Eigen::Index i = 0; i < parts; ++i) {
    double sum = 0;
    for (Eigen::Index k = i * n / parts; k < (i + 1) * n / parts; ++k)
      sum += excess[order[static_cast<std::size_t>(k)]];
    most = std::max(most, sum);
  }
  return most / std::max(excess.sum(), 1e-300);
}

}  // namespace

Remainder remainder_of(const Evidence& e, const Explanation& m, const Scatter& s, double unnamed) {
  Remainder r;
  const Eigen::ArrayXd residual = e.measured - e.path - m.addition() - mean_error(e.encoder);
  const Eigen::ArrayXd squares = residual.square();
  const double expected = s.expected.mean();
  r.ratio = std::sqrt(squares.mean() / expected);
  r.size = std::sqrt(std::max(0.0, squares.mean() - expected));
  if (r.ratio < remainder_worth_reporting || r.size < unnamed) return r;
  // At rest the rounding error is one number, of up to half a count: what is beyond it must make up the
  // excess.
  const Eigen::ArrayXd beyond =
      (residual.abs() - 0.5 * e.step() - 3 * (s.expected - e.step() * e.step() / 12).max(0.0).sqrt())
          .max(0.0);
  const Eigen::ArrayXd excess = squares - s.expected;
  if ((beyond > 0).select(excess, 0.0).sum() < 0.5 * excess.sum()) return r;
  // Single readings: a thousandth of the rows has half of the excess.
  std::vector<double> sorted(excess.begin(), excess.end());
  const auto few = static_cast<std::ptrdiff_t>(std::max<Eigen::Index>(3, e.rows() / 1000));
  std::partial_sort(sorted.begin(), sorted.begin() + std::min<std::ptrdiff_t>(few, e.rows()), sorted.end(),
                    std::greater<>());
  const double of_few =
      std::accumulate(sorted.begin(), sorted.begin() + std::min<std::ptrdiff_t>(few, e.rows()), 0.0);
  if (of_few > 0.5 * excess.sum()) {
    r.what = "single readings are far off";
    return r;
  }
  // Evenly spread, a part of twelve has a twelfth.
  constexpr double concentrated = 4.0 / parts;
  const bool at_a_place = !e.is_stationary() && largest_share(excess, e.path) > concentrated;
  const bool at_a_time = e.ordered && largest_share(excess, e.time) > concentrated;
  const bool white = !e.ordered || lag_one_correlation(residual) < correlated_residual;
  r.shape = white ? Shape::noise : Shape::unknown;
  if (at_a_place || at_a_time)
    r.what = std::string(white ? "scatter" : "an error") + " within a part of the " +
             (at_a_place ? "positions" : "record");
  else
    r.what =
        white ? "scatter that neither noise nor jitter has" : "structure without a period or a known shape";
  return r;
}

}  // namespace qerr
