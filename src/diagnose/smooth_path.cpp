#include "smooth_path.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace qerr {

namespace {

constexpr std::array<Eigen::Index, 7> half_windows{1, 2, 3, 5, 8, 12, 18};
constexpr Eigen::Index fewest_in_motion = 64;

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Divided difference of `order` at the order + 1 stamps from `first` on, scaled to unit variance of white
/// noise: takes out any polynomial of a lower order, at whatever stamps. Empty where stamps coincide.
std::optional<double> divided_difference(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x,
                                         Eigen::Index first, Eigen::Index order) {
  const double span = time[first + order] - time[first];
  double sum = 0, squares = 0;
  for (Eigen::Index i = first; i <= first + order; ++i) {
    double product = 1;
    for (Eigen::Index j = first; j <= first + order; ++j)
      if (j != i) product *= (time[i] - time[j]) / span;
    if (!(std::abs(product) > 1e-9)) return std::nullopt;
    sum += (x[i] - x[first]) / product;
    squares += 1 / (product * product);
  }
  return sum / std::sqrt(squares);
}

/// Standard deviation of white noise on a smooth path, by differences of one order.
///
/// A path that rests, written on a grid, has none in most places: then what moves must tell.
double roughness(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x, double grid, Eigen::Index order) {
  std::vector<double> all, moving;
  for (Eigen::Index k = 0; k + order < x.size(); ++k)
    if (const auto d = divided_difference(time, x, k, order)) {
      all.push_back(std::abs(*d));
      if (std::abs(x[k + order] - x[k]) > 4 * grid) moving.push_back(all.back());
    }
  const double of_all = median(std::move(all));
  const bool tells = of_all > 0 || static_cast<Eigen::Index>(moving.size()) < fewest_in_motion;
  return (tells ? of_all : median(std::move(moving))) / 0.6745;
}

/// Higher differences take out faster motion (a path sampled a few dozen times per period leaves its own
/// fourth difference), and noise stays in all of them.
double noise_of(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x, double grid) {
  double least = roughness(time, x, grid, 4);
  for (const Eigen::Index order : {6, 8})
    if (x.size() > 4 * order) least = std::min(least, roughness(time, x, grid, order));
  return least;
}

/// Weights by which samples make the value and the slope of their least-squares polynomial at `at`.
struct Fit {
  Eigen::VectorXd value, slope;

  /// @param times  of the samples [s]; a cubic through them, through three a line (and a parabola's slope)
  Fit(const Eigen::VectorXd& times, double at) {
    const double scale = std::max({times[times.size() - 1] - at, at - times[0], 1e-300});
    const Eigen::ArrayXd u = (times.array() - at) / scale;
    const Eigen::Index n = times.size();
    Eigen::MatrixXd powers(n, n == 3 ? 3 : 4);
    powers.col(0).setOnes();
    for (Eigen::Index i = 1; i < powers.cols(); ++i) powers.col(i) = powers.col(i - 1).array() * u;
    value = row(n == 3 ? Eigen::MatrixXd(powers.leftCols(2)) : powers, 0);
    slope = row(powers, 1) / scale;
  }

 private:
  /// Of (P^T P)^-1 P^T. Coinciding stamps share what they have (the tiny ridge).
  static Eigen::VectorXd row(const Eigen::MatrixXd& powers, Eigen::Index which) {
    Eigen::MatrixXd normal = powers.transpose() * powers;
    normal.diagonal().array() += 1e-12 * normal.diagonal().maxCoeff();
    return powers * normal.ldlt().solve(Eigen::VectorXd::Unit(normal.cols(), which));
  }
};

/// The path by local fits over 2 h + 1 samples.
struct Smoothed {
  Eigen::ArrayXd position, velocity;
  double left = 0;  ///< standard deviation of white noise that would leave the same residual
  double kept = 1;  ///< part of white noise that stays in the position
};

bool is_even(const Eigen::ArrayXd& time) {
  const Eigen::Index n = time.size();
  const double interval = (time[n - 1] - time[0]) / static_cast<double>(n - 1);
  return ((time - time[0] - interval * Eigen::ArrayXd::LinSpaced(n, 0, static_cast<double>(n - 1))).abs() <
          1e-3 * interval)
      .all();
}

Smoothed smoothed(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x, Eigen::Index h, bool even) {
  const Eigen::Index n = x.size();
  Smoothed out{x, Eigen::ArrayXd::Zero(n), 0};
  const Fit common(time.segment(0, 2 * h + 1), time[h]);
  double squares = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index first = std::clamp(k - h, Eigen::Index{0}, n - 1 - 2 * h);
    const bool inside = first == k - h;
    const Fit own = even && inside ? common : Fit(time.segment(first, 2 * h + 1), time[k]);
    // Relative to the sample itself, so that a long way from zero costs no digits.
    const Eigen::VectorXd window = (x.segment(first, 2 * h + 1) - x[k]).matrix();
    out.velocity[k] = own.slope.dot(window);
    // At the ends a fit would lean on one side only: keep what was recorded.
    if (!inside) continue;
    const double shift = own.value.dot(window);
    out.position[k] = x[k] + shift;
    squares += shift * shift / std::max(1 - own.value[h], 1e-3);
  }
  out.kept = std::sqrt(std::max(0.0, common.value[h]));
  out.left = std::sqrt(squares / static_cast<double>(n - 2 * h));
  return out;
}

}  // namespace

SmoothPath smooth_path(const Eigen::ArrayXd& time, const Eigen::ArrayXd& recorded, double grid) {
  const Eigen::Index n = recorded.size();
  SmoothPath best{recorded, Eigen::ArrayXd::Zero(n), 0, 1};
  if (n < 8 || !(time[n - 1] > time[0])) return {recorded, Eigen::ArrayXd::Zero(n), 0, 0};
  const double noise = std::max(noise_of(time, recorded, grid), grid / std::sqrt(12.0));
  const bool even = is_even(time);
  bool first = true;
  for (const Eigen::Index h : half_windows) {
    if (2 * h + 1 > n / 3) break;
    Smoothed s = smoothed(time, recorded, h, even);
    if (!first && s.left > 1.15 * noise) break;
    best.velocity = std::move(s.velocity);
    if (!first) best.position = std::move(s.position), best.left = s.kept;
    first = false;
  }
  best.noise = noise;
  best.left *= noise;
  return best;
}

Eigen::ArrayXd side_of_motion(const Eigen::ArrayXd& path, double threshold) {
  Eigen::ArrayXd side = Eigen::ArrayXd::Zero(path.size());
  Eigen::Index low = 0, high = 0;  // of the lowest and highest point since the last reversal
  double now = 0;
  for (Eigen::Index k = 0; k < path.size(); ++k) {
    if (path[k] <= path[low]) low = k;
    if (path[k] >= path[high]) high = k;
    const bool rose = now <= 0 && path[k] > path[low] + threshold;
    const bool fell = now >= 0 && path[k] < path[high] - threshold;
    if (rose || fell) {
      // The motion turned at the extreme, not where it had become certain.
      const Eigen::Index turn = rose ? low : high;
      now = rose ? 1 : -1;
      side.segment(turn + 1, k - turn).setConstant(now);
      low = high = k;
    }
    side[k] = now;
  }
  return side;
}

}  // namespace qerr
