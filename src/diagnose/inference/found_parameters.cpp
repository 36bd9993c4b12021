#include "diagnose/inference/found_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/solve.hpp"
#include "core/statistics.hpp"
#include "diagnose/record/sampling.hpp"

namespace qerr {

std::string shape_name(const Term& t) {
  if (!t.reshaped) return "";
  for (const auto& [name, value] : t.effect.numbers)
    if (value == t.shape) return name;
  return "";
}

Eigen::ArrayXd shape_column(const Evidence& e, const Term& t, const Eigen::VectorXd& coefficients) {
  const double change = 1e-3 * (t.half_width > 0 ? t.half_width : std::abs(t.shape));
  const Term more = t.reshaped(e, t, t.shape + change), less = t.reshaped(e, t, t.shape - change);
  return ((more.columns - less.columns).matrix() * coefficients).array() / (2 * change);
}

namespace {

constexpr double normal_quantile_95 = 1.959963984540054;
constexpr double half_chi_squared = 1.92;

/// Covariance of all that was fitted, twice: by the curvature alone, and with the scatter of the blocks.
struct Covariance {
  Eigen::MatrixXd curvature, sandwich;
  double quantile = normal_quantile_95;  ///< for the second

  /// Half the width of the 95 % interval of a combination of the coefficients.
  double half_width(const Eigen::VectorXd& derivative) const {
    const auto sigma = [&](const Eigen::MatrixXd& v) {
      return std::sqrt(std::max(0.0, derivative.dot(v * derivative)));
    };
    return interval_calibration * std::max(normal_quantile_95 * sigma(curvature), quantile * sigma(sandwich));
  }
};

Covariance covariance(const Evidence& e, const IntervalLikelihood& l, const Eigen::MatrixXd& columns) {
  Eigen::VectorXd scale = columns.colwise().norm();
  for (double& s : scale) s = s > 0 ? 1 / s : 1;
  const Eigen::MatrixXd unit = columns * scale.asDiagonal();
  Eigen::MatrixXd information = unit.transpose() * l.curvature.matrix().asDiagonal() * unit;
  information.diagonal().array() *= 1 + 1e-10;
  information.diagonal().array() += 1e-12 * information.diagonal().mean() + 1e-300;
  const Eigen::MatrixXd inverse = symmetric_inverse(information);
  const std::vector<Eigen::Index> starts = block_starts(e);
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(starts.size()), unit.cols());
  for (std::size_t b = 0; b < starts.size(); ++b) {
    const Eigen::Index end = b + 1 < starts.size() ? starts[b + 1] : e.rows(), size = end - starts[b];
    scores.row(static_cast<Eigen::Index>(b)) =
        l.score.segment(starts[b], size).matrix().transpose() * unit.middleRows(starts[b], size);
  }
  Covariance c;
  c.curvature = scale.asDiagonal() * inverse * scale.asDiagonal();
  c.sandwich = Eigen::MatrixXd::Zero(unit.cols(), unit.cols());
  const auto free = static_cast<double>(starts.size()) - 1;
  if (free < 3) return c;
  c.sandwich = scale.asDiagonal() * inverse * (scores.transpose() * scores) * inverse * scale.asDiagonal() *
               ((free + 1) / free);
  c.quantile = student_t_quantile(0.975, free);
  return c;
}

/// Change of every filled parameter with the coefficients.
Eigen::VectorXd derivative_of(const Term& t, const Eigen::VectorXd& coefficients, const std::string& name) {
  Eigen::VectorXd d(coefficients.size());
  const double change = 1e-5 * std::max(coefficients.norm(), 1e-12);
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    Effect more = t.effect, less = t.effect;
    const Eigen::VectorXd step = change * Eigen::VectorXd::Unit(d.size(), i);
    t.fill(more, coefficients + step);
    t.fill(less, coefficients - step);
    double by = more.number(name) - less.number(name);
    if (name == "phase" && t.size() == 2) by = std::remainder(by, 2 * std::numbers::pi);
    d[i] = by / (2 * change);
  }
  return d;
}

double log_likelihood_of_row(const Explanation& m, Eigen::Index row, double position) {
  const Intervals one{m.intervals().lower.segment(row, 1), m.intervals().upper.segment(row, 1)};
  return interval_likelihood(one, Eigen::ArrayXd::Constant(1, position),
                             Eigen::ArrayXd::Constant(1, m.scatter()[row]))
      .log_likelihood;
}

/// Time of a step; its interval contains the readings to which the step can move while the log-likelihood
/// falls by less than `half_chi_squared`.
FoundParameter step_time(const Evidence& e, const Explanation& m, std::size_t term) {
  const Term& t = m.terms()[term];
  const double time = t.effect.number("time"), height = m.coefficients(term)[0] * e.step();
  Eigen::Index first = 0;
  while (first + 1 < e.rows() && e.time[first] < time) ++first;
  Eigen::Index earliest = first, latest = first;
  double change = 0;
  constexpr Eigen::Index most = 400;
  for (Eigen::Index k = first - 1; k > std::max<Eigen::Index>(0, first - most) && change > -10; --k) {
    change +=
        log_likelihood_of_row(m, k, m.addition()[k] + height) - log_likelihood_of_row(m, k, m.addition()[k]);
    if (change > -half_chi_squared) earliest = k;
  }
  change = 0;
  for (Eigen::Index k = first; k + 1 < std::min(e.rows(), first + most) && change > -10; ++k) {
    change +=
        log_likelihood_of_row(m, k, m.addition()[k] - height) - log_likelihood_of_row(m, k, m.addition()[k]);
    if (change > -half_chi_squared) latest = k + 1;
  }
  return {"time", time, std::min(time, e.time[std::max<Eigen::Index>(earliest - 1, 0)]),
          std::max(time, e.time[latest])};
}

}  // namespace

std::vector<std::vector<FoundParameter>> found_parameters(const Evidence& e, const Explanation& m) {
  if (m.terms().empty()) return {};
  Eigen::Index count = e.encoder.zero_known ? 0 : 1;
  const Eigen::Index base = count;
  for (const Term& t : m.terms()) count += t.size() + (shape_name(t).empty() ? 0 : 1);
  Eigen::MatrixXd columns = Eigen::MatrixXd::Ones(e.rows(), count);
  Eigen::Index at = base;
  for (std::size_t i = 0; i < m.terms().size(); ++i) {
    const Term& t = m.terms()[i];
    columns.middleCols(at, t.size()) = t.columns.matrix();
    at += t.size();
    if (!shape_name(t).empty()) columns.col(at++) = shape_column(e, t, m.coefficients(i)).matrix();
  }
  const Covariance c = covariance(e, m.likelihood(), columns);
  // Where rounding drifts with the path as slowly as the record lasts, hardly a reading tells: what two
  // models of the same readings differ by, a count a row and their noise, limits the difference of their
  // parameters.
  const auto limit = [&,
                      inverse = symmetric_inverse(columns.transpose() * columns)](const Eigen::VectorXd& d) {
    return (e.step() + 2 * m.noise()) * (columns * (inverse * d)).lpNorm<1>();
  };
  std::vector<std::vector<FoundParameter>> found;
  at = base;
  for (std::size_t i = 0; i < m.terms().size(); ++i) {
    const Term& t = m.terms()[i];
    const std::string shape = shape_name(t);
    Effect effect = t.effect;
    t.fill(effect, m.coefficients(i));
    auto& mine = found.emplace_back();
    for (const auto& [name, value] : effect.numbers) {
      if (t.step && name == "time") {
        mine.push_back(step_time(e, m, i));
        continue;
      }
      Eigen::VectorXd derivative = Eigen::VectorXd::Zero(count);
      if (name == shape) derivative[at + t.size()] = 1;
      derivative.segment(at, t.size()) += derivative_of(t, m.coefficients(i), name);
      // A reading that never changes says within which count the joint rests, and no more.
      const double half = t.constant && e.is_stationary() ? std::max(0.5 * e.step(), 2 * e.noise)
                          : t.step && columns.col(at).any()
                              ? std::min(c.half_width(derivative), limit(derivative))
                              : c.half_width(derivative);
      mine.push_back({name, value, value - half, value + half});
    }
    at += t.size() + (shape.empty() ? 0 : 1);
  }
  return found;
}

}  // namespace qerr
