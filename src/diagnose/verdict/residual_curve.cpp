#include "diagnose/verdict/residual_curve.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/statistics.hpp"
#include "qerr/effect/effect.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index bins = 40;

struct Argument {
  std::string name, unit;
  Eigen::ArrayXd values;
};

/// Means of a column in bins of a quantity; NaN: no rows.
Eigen::ArrayXd binned(const Eigen::ArrayXd& column, const Eigen::ArrayXd& by, double low, double width) {
  Eigen::ArrayXd sums = Eigen::ArrayXd::Zero(bins), counts = sums;
  for (Eigen::Index k = 0; k < column.size(); ++k) {
    const auto bin = std::min(bins - 1, static_cast<Eigen::Index>((by[k] - low) / width));
    sums[bin] += column[k], counts[bin] += 1;
  }
  return sums / counts;
}

/// Mean square of a column about its means in the bins.
double scatter_within(const Eigen::ArrayXd& column, const Eigen::ArrayXd& by) {
  const double low = by.minCoeff(), width = (by.maxCoeff() - low) / bins;
  if (!(width > 0)) return column.square().mean();
  const Eigen::ArrayXd means = binned(column, by, low, width);
  double sum = 0;
  for (Eigen::Index k = 0; k < column.size(); ++k)
    sum +=
        std::pow(column[k] - means[std::min(bins - 1, static_cast<Eigen::Index>((by[k] - low) / width))], 2);
  return sum / static_cast<double>(column.size());
}

std::vector<Argument> quantities(const Evidence& e, const Term& t) {
  const std::string coordinate = e.prismatic ? "m" : "rad";
  std::vector<Argument> all{{"angle", coordinate, e.path}};
  if (e.prismatic) all[0].name = "position";
  if (e.ordered) {
    all.push_back({"speed", coordinate + "/s", e.velocity});
    all.push_back({"time", "s", e.time});
  }
  if (e.effort.size() > 0) all.push_back({"effort", e.prismatic ? "N" : "N m", e.effort});
  if (e.temperature.size() > 0) all.push_back({"temperature", "K", e.temperature});
  if (const double order = std::abs(wave_number(t.effect, e.encoder)); t.harmonic && order > 0) {
    const double period = 2 * std::numbers::pi / order;
    all.push_back({all[0].name, coordinate,
                   e.path.unaryExpr([&](double x) { return x - period * std::floor(x / period); })});
  }
  return all;
}

}  // namespace

ResidualCurve residual_curve(const Evidence& e, const Explanation& m, std::size_t term) {
  const Term& t = m.terms()[term];
  const Eigen::ArrayXd added = addition(t, m.coefficients(term));
  ResidualCurve curve;
  if (t.constant || standard_deviation(added) == 0 || e.rows() < 2 * bins) return curve;
  const Eigen::ArrayXd residual = e.measured - e.path - m.addition() + added;
  std::vector<Argument> all = quantities(e, t);
  std::size_t best = 0;
  double least = scatter_within(added, all[0].values);
  for (std::size_t i = 1; i < all.size(); ++i)
    if (const double here = scatter_within(added, all[i].values); here < least) least = here, best = i;
  const Argument& q = all[best];
  const double low = q.values.minCoeff(), width = (q.values.maxCoeff() - low) / bins;
  const Eigen::ArrayXd observed = binned(residual, q.values, low, width),
                       fit = binned(added, q.values, low, width);
  curve.against = q.name, curve.unit = q.unit;
  for (Eigen::Index i = 0; i < bins; ++i) {
    curve.at.push_back(low + (static_cast<double>(i) + 0.5) * width);
    curve.residual.push_back(observed[i]);
    curve.fit.push_back(fit[i]);
  }
  return curve;
}

}  // namespace qerr
