#include "check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace qerr::bench {

namespace {

constexpr double not_shown = std::numeric_limits<double>::quiet_NaN();

/// Largest |a - b| over largest |b|, over the rows with the same `group(row)`. A NaN is an infinite
/// deviation.
template <typename Group>
double relative(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Group group) {
  std::array<double, 3> difference{}, size{};
  for (Eigen::Index row = 0; row < b.rows(); ++row) {
    const auto g = static_cast<std::size_t>(group(row));
    const auto apart = (a.row(row) - b.row(row)).array().abs().eval();
    const bool finite = apart.isFinite().all();
    difference[g] =
        std::max(difference[g], finite ? apart.maxCoeff() : std::numeric_limits<double>::infinity());
    size[g] = std::max(size[g], b.row(row).cwiseAbs().maxCoeff());
  }
  const double least = 1e-4 * *std::max_element(size.begin(), size.end());
  double worst = 0;
  for (std::size_t g = 0; g < size.size(); ++g)
    if (difference[g] > 0) worst = std::max(worst, difference[g] / std::max(size[g], least));
  return worst;
}

/// Group of a coordinate: 0 positions, 1 rotations.
int unit(Eigen::Index coordinate) { return coordinate % 6 < 3 ? 0 : 1; }

/// Group of an entry of the covariance: 0 positions, 1 mixed, 2 rotations.
int unit_of_entry(Eigen::Index entry) {
  int row = 0;
  while (entry > row) entry -= ++row;
  return unit(row) + unit(entry);
}

/// Worst case or sigma (in the order of Summaries) at configuration q, by the scalar reference.
double figure_at(const Problem& p, std::size_t figure, const Eigen::VectorXd& q) {
  const OperationalError e = operational_error(p.model, q);
  return figure < 6 ? e.worst_case[static_cast<Eigen::Index>(figure)]
                    : e.sigma[static_cast<Eigen::Index>(figure - 6)];
}

void compare(const Summaries& a, const Summaries& b, const Problem& p, Deviation& d) {
  const auto rows = static_cast<Eigen::Index>(b.size());
  if (a.size() != b.size()) {
    d.summary = std::numeric_limits<double>::infinity();
    return;
  }
  Eigen::MatrixXd sums_a(rows, 3), sums_b(rows, 3), quantiles_a(rows, 3), quantiles_b(rows, 3);
  for (std::size_t i = 0; i < b.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    sums_a.row(row) << a[i].max, a[i].mean, figure_at(p, i, a[i].at_max);
    sums_b.row(row) << b[i].max, b[i].mean, b[i].max;
    quantiles_a.row(row) << a[i].p50, a[i].p95, a[i].p99;
    quantiles_b.row(row) << b[i].p50, b[i].p95, b[i].p99;
  }
  d.summary = relative(sums_a, sums_b, unit);
  d.quantile = relative(quantiles_a, quantiles_b, unit);
}

}  // namespace

bool Deviation::agrees() const {
  for (const double shown : {jacobian, worst_case, covariance})
    if (shown > largest_allowed) return false;
  return !(summary > largest_summary_allowed) && !(quantile > largest_quantile_allowed);
}

Deviation deviation(const Contestant& contestant, const Contestant& reference, const Problem& p,
                    std::uint64_t count) {
  const auto columns = static_cast<Eigen::Index>(count);
  Deviation d{not_shown, not_shown, not_shown, not_shown, not_shown};
  const Run run = contestant.prepare(p), reference_run = reference.prepare(p);
  if (contestant.does(Stage::job)) {
    Recording theirs(Stage::job, p.points.rows(), columns), right = theirs,
                                                            alone(Stage::jac, p.points.rows(), columns);
    run(Stage::jac, count, &alone);
    run(Stage::job, count, &theirs);
    reference_run(Stage::job, count, &right);
    const auto by_row = [](Eigen::Index entry) { return unit(entry % 6); };
    d.jacobian = std::max(relative(theirs.jacobians, right.jacobians, by_row),
                          relative(alone.jacobians, right.jacobians, by_row));
    d.worst_case = relative(theirs.worst_cases, right.worst_cases, unit);
    d.covariance = relative(theirs.covariances, right.covariances, unit_of_entry);
  }
  if (contestant.does(Stage::full))
    compare(run(Stage::full, count, nullptr), reference_run(Stage::full, count, nullptr), p, d);
  return d;
}

}  // namespace qerr::bench
