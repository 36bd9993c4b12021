#include "smooth_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace qerr {

namespace {

constexpr std::array<Eigen::Index, 7> half_windows{1, 2, 3, 5, 8, 12, 18};

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Of white noise, from fourth differences: they take out any cubic, and have 70 times its variance.
double roughness(const Eigen::ArrayXd& x) {
  std::vector<double> differences;
  for (Eigen::Index k = 2; k + 2 < x.size(); ++k)
    differences.push_back(std::abs(x[k - 2] - 4 * x[k - 1] + 6 * x[k] - 4 * x[k + 1] + x[k + 2]));
  return median(std::move(differences)) / 0.6745 / std::sqrt(70.0);
}

/// Cubic through 2 h + 1 points by least squares: its value and slope in the middle. Moments of symmetric
/// windows.
struct Window {
  std::vector<double> value, slope;  // weights of x[k - h .. k + h]; slope per sample
  double kept = 0;                   // of white noise' variance in the residual

  explicit Window(Eigen::Index h) {
    double s0 = 0, s2 = 0, s4 = 0, s6 = 0;
    for (Eigen::Index i = -h; i <= h; ++i) {
      const auto d = static_cast<double>(i);
      s0 += 1, s2 += d * d, s4 += std::pow(d, 4), s6 += std::pow(d, 6);
    }
    for (Eigen::Index i = -h; i <= h; ++i) {
      const auto d = static_cast<double>(i);
      // With three points a cubic would be no fit: a parabola for the value, a chord for the slope.
      value.push_back(h == 1 ? 1.0 / 3 : (s4 - s2 * d * d) / (s0 * s4 - s2 * s2));
      slope.push_back(h == 1 ? 0.5 * d : (s6 * d - s4 * d * d * d) / (s2 * s6 - s4 * s4));
    }
    kept = 1 - value[static_cast<std::size_t>(h)];
  }
};

Eigen::ArrayXd apply(const std::vector<double>& weights, const Eigen::ArrayXd& x, Eigen::Index h) {
  Eigen::ArrayXd out(x.size());
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const Eigen::Index middle = std::clamp(k, h, std::max(h, x.size() - 1 - h));
    double sum = 0;
    for (Eigen::Index i = -h; i <= h; ++i) sum += weights[static_cast<std::size_t>(i + h)] * x[middle + i];
    out[k] = sum;
  }
  return out;
}

double rms(const Eigen::ArrayXd& x) { return x.size() == 0 ? 0 : std::sqrt(x.square().mean()); }

}  // namespace

SmoothPath smooth_path(const Eigen::ArrayXd& time, const Eigen::ArrayXd& recorded, double grid) {
  const Eigen::Index n = recorded.size();
  SmoothPath best{recorded, Eigen::ArrayXd::Zero(n), 0};
  if (n < 8) return best;
  const double noise = std::max(roughness(recorded), grid / std::sqrt(12.0));
  const double interval = (time[n - 1] - time[0]) / static_cast<double>(n - 1);
  bool first = true;
  for (const Eigen::Index h : half_windows) {
    if (2 * h + 1 > n / 3) break;
    const Window window(h);
    Eigen::ArrayXd smooth = apply(window.value, recorded, h);
    // At the ends the middle's value would stand for all: keep what was recorded.
    smooth.head(h) = recorded.head(h);
    smooth.tail(h) = recorded.tail(h);
    const double left = rms((recorded - smooth).segment(h, n - 2 * h));
    if (!first && left > 1.15 * noise * std::sqrt(window.kept)) break;
    best.velocity = apply(window.slope, recorded, h) / interval;
    best.position = first ? recorded : smooth;
    first = false;
  }
  best.noise = noise;
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
