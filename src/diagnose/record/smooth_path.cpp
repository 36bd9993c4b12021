#include "diagnose/record/smooth_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/solve.hpp"
#include "core/statistics.hpp"

namespace qerr {

namespace {

constexpr std::array<Eigen::Index, 7> half_windows{1, 2, 3, 5, 8, 12, 18};
constexpr Eigen::Index fewest_in_motion = 64;  ///< differences, for a median (convention)

/// Rows from which noise is estimated: a standard deviation from n values has the relative error
/// 1/sqrt(2 n) = 0.5 %, a median absolute deviation 0.8 %.
constexpr Eigen::Index enough_rows = 20000;

/// Median absolute value of a standard normal variable.
constexpr double normal_median = 0.6745;

/// Excess of the residual over the noise at which the window distorts the path (convention).
constexpr double distorted = 1.06;

/// That excess with few rows, where the noise itself is an estimate: three of its standard deviations. A
/// median absolute deviation has 1/sqrt(0.74 n), and as neighbouring differences of fourth order share
/// samples, of n rows n/2.6 count.
double distorted_of(Eigen::Index rows) {
  return std::max(distorted,
                  1 + 3 * std::sqrt(2.6 / (0.74 * static_cast<double>(std::min(rows, enough_rows)))));
}

/// Distance of the rows that are used of a long record.
Eigen::Index stride_of(Eigen::Index rows) { return std::max<Eigen::Index>(1, rows / enough_rows); }

/// Standard deviation of white noise on a smooth path, from divided differences of one order, each over
/// order + 1 rows and scaled to unit variance for white noise. They are zero for polynomials of lower order,
/// at any stamps; where stamps coincide there is none.
///
/// A rounded path is constant at standstill and shows no noise there. If that is most of the record, only
/// differences in motion are used.
double roughness(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x, double log_resolution,
                 Eigen::Index order) {
  constexpr Eigen::Index block = 512;  // differences at a time: their columns stay in the cache
  const Eigen::Index stride = stride_of(x.size()), count = (x.size() - order + stride - 1) / stride;
  std::vector<double> all, moving;
  Eigen::ArrayXXd t(block, order + 1), y(block, order + 1), products;
  Eigen::ArrayXd apart;
  for (Eigen::Index done = 0; done < count; done += block) {
    const Eigen::Index size = std::min(block, count - done);
    t.resize(size, order + 1), y.resize(size, order + 1);
    for (Eigen::Index i = 0; i <= order; ++i) {
      const auto rows = Eigen::seqN(done * stride + i, size, stride);
      t.col(i) = time(rows), y.col(i) = x(rows);
    }
    const Eigen::ArrayXd start = t.col(0), span = t.col(order) - start;
    t = (t.colwise() - start).colwise() / span;
    products.setOnes(size, order + 1);
    for (Eigen::Index i = 1; i <= order; ++i)
      for (Eigen::Index j = 0; j < i; ++j) {
        apart = t.col(i) - t.col(j);
        products.col(i) *= apart, products.col(j) *= -apart;
      }
    const Eigen::ArrayXd least = products.abs().rowwise().minCoeff();
    const Eigen::ArrayXXd weights = products.inverse();
    Eigen::ArrayXd sum = (weights * (y.colwise() - y.col(0))).rowwise().sum();
    const Eigen::ArrayXd squares = weights.square().rowwise().sum();
    const Eigen::ArrayXd moved = (y.col(order) - y.col(0)).abs();
    sum = (sum / squares.sqrt()).abs();
    for (Eigen::Index k = 0; k < size; ++k) {
      if (!(least[k] > 1e-9)) continue;
      all.push_back(sum[k]);
      if (moved[k] > 4 * log_resolution) moving.push_back(sum[k]);
    }
  }
  const double of_all = median(std::move(all));
  const bool use_all = of_all > 0 || static_cast<Eigen::Index>(moving.size()) < fewest_in_motion;
  return (use_all ? of_all : median(std::move(moving))) / normal_median;
}

/// The smallest estimate of several orders. Higher differences suppress faster motion (with a few dozen
/// samples per period the path contributes to the fourth difference), while noise has the same variance in
/// all of them.
double noise_of(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x, double log_resolution) {
  double least = roughness(time, x, log_resolution, 4);
  for (const Eigen::Index order : {6, 8})
    if (x.size() > 4 * order) least = std::min(least, roughness(time, x, log_resolution, order));
  return least;
}

/// Whether there are enough rows for the differences, at more than one time.
bool has_path(const Eigen::ArrayXd& time) { return time.size() >= 8 && time[time.size() - 1] > time[0]; }

/// Weights of the samples in the value and the derivatives of their least-squares polynomial at one time.
struct FitWeights {
  Eigen::VectorXd value, slope, curvature;

  /// A cubic, or of another degree; through three samples a line for the value and a parabola for the
  /// derivatives.
  /// @param times   of the samples [s]
  /// @param centre  where the polynomial is evaluated [s]
  FitWeights(const Eigen::VectorXd& times, double centre, Eigen::Index degree = 3) {
    const double scale = std::max({times[times.size() - 1] - centre, centre - times[0], 1e-300});
    const Eigen::ArrayXd u = (times.array() - centre) / scale;
    const Eigen::Index n = times.size();
    Eigen::MatrixXd powers(n, std::min(n, degree + 1));
    powers.col(0).setOnes();
    for (Eigen::Index i = 1; i < powers.cols(); ++i) powers.col(i) = powers.col(i - 1).array() * u;
    value = row(n == 3 ? Eigen::MatrixXd(powers.leftCols(2)) : powers, 0);
    slope = row(powers, 1) / scale;
    curvature = 2 * row(powers, 2) / (scale * scale);
  }

 private:
  /// Row of (P^T P)^-1 P^T. The small ridge gives samples with equal stamps equal weight.
  static Eigen::VectorXd row(const Eigen::MatrixXd& powers, Eigen::Index which) {
    Eigen::MatrixXd normal = powers.transpose() * powers;
    normal.diagonal().array() += 1e-12 * normal.diagonal().maxCoeff();
    return powers * solve_symmetric(normal, Eigen::VectorXd::Unit(normal.cols(), which));
  }
};

/// The interval of nearly all stamps, apart from gaps [s]; 0 if the stamps are uneven.
double common_interval(const Eigen::ArrayXd& time) {
  const Eigen::Index n = time.size();
  const Eigen::ArrayXd steps = time.tail(n - 1) - time.head(n - 1);
  const double usual = median({steps.begin(), steps.end()});
  return ((steps - usual).abs() < 1e-3 * usual).count() >= n - 1 - n / 1000 ? usual : 0;
}

/// Local fits over 2 h + 1 samples.
class Window {
  Eigen::Index first(Eigen::Index k) const {
    return std::clamp(k - h_, Eigen::Index{0}, x_.size() - 1 - 2 * h_);
  }
  /// Relative to the sample itself, so that large positions lose no digits.
  auto window_at(Eigen::Index k) const { return (x_.segment(first(k), 2 * h_ + 1) - x_[k]).matrix(); }

  /// Stamps of a window, relative to its centre.
  static Eigen::VectorXd stamps(const Eigen::ArrayXd& time, Eigen::Index h, double interval) {
    if (interval > 0)
      return interval *
             Eigen::VectorXd::LinSpaced(2 * h + 1, -static_cast<double>(h), static_cast<double>(h));
    return time.segment(0, 2 * h + 1) - time[h];
  }

 public:
  Window(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x, Eigen::Index h, double interval)
      : time_(time), x_(x), h_(h), interval_(interval), common_(stamps(time, h, interval), 0) {}

  /// Standard deviation of unit white noise after smoothing.
  double noise_gain() const { return std::sqrt(std::max(0.0, common_.value[h_])); }

  /// Standard deviation of white noise that would give the residual of this window.
  double residual_noise() const {
    double squares = 0, count = 0;
    std::optional<FitWeights> own;
    for (Eigen::Index k = h_; k < x_.size() - h_; k += stride_of(x_.size())) {
      const FitWeights& here = fit(k, own);
      const double shift = here.value.dot(window_at(k));
      squares += shift * shift / std::max(1 - here.value[h_], 1e-3);
      ++count;
    }
    return std::sqrt(squares / count);
  }

  /// Whether this window has moved the path of a narrower one by more than noise does: a distortion that the
  /// residual, most of which is noise, does not show yet. Of differences of overlapping windows few are
  /// independent.
  bool distorts(const Window& narrower, double noise) const {
    constexpr double deviations = 3, least = 0.15;
    double squares = 0, expected = 0;
    std::optional<FitWeights> own, own_of_narrower;
    for (Eigen::Index k = h_; k < x_.size() - h_; k += stride_of(x_.size())) {
      const FitWeights &here = fit(k, own), &of_narrower = narrower.fit(k, own_of_narrower);
      squares += std::pow(here.value.dot(window_at(k)) - of_narrower.value.dot(narrower.window_at(k)), 2);
      // The difference of nested fits has the difference of their variances.
      expected += of_narrower.value[narrower.h_] - here.value[h_];
    }
    const double independent = static_cast<double>(x_.size()) / static_cast<double>(2 * narrower.h_ + 1);
    return squares >
           (1 + std::max(least, deviations * std::sqrt(2 / independent))) * expected * noise * noise;
  }

  bool is_line() const { return h_ == half_windows.front(); }

  double velocity(Eigen::Index k) const {
    std::optional<FitWeights> own;
    return fit(k, own).slope.dot(window_at(k));
  }

  /// Position and its derivatives at every row. At the ends a fit would be one-sided: there the position is
  /// the recorded one. Where a corner of the motion distorts this window and hardly any other, the row has
  /// the widest of the narrower ones that agrees with those narrower still (Lepski 1991).
  /// @param narrower  ascending
  SmoothPath path(double noise, const std::vector<Window>& narrower) const {
    const bool smoothed = !is_line();  // a line through three samples hardly reduces noise
    // A curvature of three samples would be noise.
    SmoothPath out{x_, Eigen::ArrayXd(x_.size()), Eigen::ArrayXd(smoothed ? x_.size() : 0), noise, noise};
    std::optional<FitWeights> own;
    Eigen::VectorXd window;
    const auto set = [&](Eigen::Index k, const Window& w) {
      const FitWeights& here = w.fit(k, own);
      window = w.window_at(k);
      out.velocity[k] = here.slope.dot(window);
      if (!smoothed) return;
      out.acceleration[k] = here.curvature.dot(window);
      if (first(k) == k - h_) out.position[k] = x_[k] + here.value.dot(window);
    };
    for (Eigen::Index k = 0; k < x_.size(); ++k) set(k, *this);
    if (smoothed && !narrower.empty()) {
      // At a corner means of five residuals, of which noise has 0.45, are of the size of the distortion,
      // which is more than the noise of a row before narrower windows disagree.
      constexpr double suspicious = 0.7;
      const Eigen::ArrayXd left = x_ - out.position;
      for (Eigen::Index k = h_; k + h_ < x_.size(); ++k)
        if (std::abs(left.segment<5>(k - 2).mean()) > suspicious * noise)
          set(k, undistorted(k, noise, narrower));
    }
    if (smoothed) out.residual_noise *= noise_gain();
    return out;
  }

 private:
  /// This window, or at a row that it distorts one that agrees with all narrower ones: of nested fits the
  /// difference has the difference of their variances as its own, of which four deviations are exceeded in
  /// 6e-5 of the rows.
  const Window& undistorted(Eigen::Index k, double noise, const std::vector<Window>& narrower) const {
    constexpr double deviations = 4;
    if (first(k) != k - h_) return *this;
    const auto at = [&](const Window& w) {
      std::optional<FitWeights> own;
      return w.fit(k, own).value.dot(w.window_at(k));
    };
    const Window* best = this;
    double value = at(*this);
    for (std::size_t i = narrower.size(); i-- > 0;) {
      const Window& w = narrower[i];
      if (w.is_line()) break;
      const double own = at(w), variance = std::pow(w.noise_gain(), 2) - std::pow(best->noise_gain(), 2);
      if (std::abs(own - value) > deviations * noise * std::sqrt(std::max(0.0, variance)))
        best = &w, value = own;
    }
    return *best;
  }

  const FitWeights& fit(Eigen::Index k, std::optional<FitWeights>& own) const {
    const double width = 2 * static_cast<double>(h_) * interval_;
    if (first(k) == k - h_ && std::abs(time_[k + h_] - time_[k - h_] - width) < 1e-3 * interval_)
      return common_;
    return own.emplace(Eigen::VectorXd(time_.segment(first(k), 2 * h_ + 1)), time_[k]);
  }

  const Eigen::ArrayXd &time_, &x_;
  Eigen::Index h_;
  double interval_;    ///< of even stamps; 0: stamps are uneven
  FitWeights common_;  ///< of windows without gaps
};

/// The path as recorded, with velocity and acceleration where nine samples are even by the polynomial through
/// them: of a sine of p samples a period the velocity is short by (2 pi/p)^8/630 in their middle, that of
/// three samples by (2 pi/p)^2/6. At the ends it would have 33 times the noise of a sample as velocity of an
/// interval: there a polynomial of the fifth degree, 3 times, is fitted to them.
SmoothPath with_interpolated_rates(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x, double interval,
                                   const Window& narrow, double noise) {
  constexpr Eigen::Index width = 9, half = width / 2, degree_at_ends = 5;
  using Weights = Eigen::Matrix<double, width, 1>;
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(width, 0, (width - 1) * interval);
  std::vector<Weights> slopes, curvatures;
  for (Eigen::Index at = 0; at < width; ++at) {
    const FitWeights fit(times, times[at], at == half ? width - 1 : degree_at_ends);
    slopes.push_back(fit.slope), curvatures.push_back(fit.curvature);
  }
  SmoothPath path{x, Eigen::ArrayXd(x.size()), Eigen::ArrayXd::Zero(x.size()), noise, noise};
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const Eigen::Index first = std::clamp(k - half, Eigen::Index{0}, x.size() - width);
    const double span = time[first + width - 1] - time[first];
    if (std::abs(span - (width - 1) * interval) > 1e-3 * interval) {
      path.velocity[k] = narrow.velocity(k);
      continue;
    }
    const auto at = static_cast<std::size_t>(k - first);
    const Weights window = x.segment<width>(first) - x[k];
    path.velocity[k] = slopes[at].dot(window);
    path.acceleration[k] = curvatures[at].dot(window);
  }
  return path;
}

}  // namespace

double position_at(const Eigen::ArrayXd& time, const Eigen::ArrayXd& path, const Eigen::ArrayXd& velocity,
                   double instant) {
  Eigen::Index row = 0;
  return position_at(time, path, velocity, instant, row);
}

double position_at(const Eigen::ArrayXd& time, const Eigen::ArrayXd& path, const Eigen::ArrayXd& velocity,
                   double instant, Eigen::Index& row) {
  const Eigen::Index last = time.size() - 1;
  const auto is_before = [&] { return row < last && time[row] <= instant && instant < time[row + 1]; };
  if (!is_before() && (++row, !is_before())) {
    const auto next = std::upper_bound(time.begin(), time.end(), instant);
    row = std::clamp<Eigen::Index>(next - time.begin() - 1, 0, last);
  }
  const Eigen::Index k = row;
  if (k == last || !(instant >= time[0])) {
    const double beyond = instant - time[k];
    const double back = std::clamp(time[k] - beyond, time[0], time[time.size() - 1]);
    if (!(std::abs(back - time[k]) > 0))
      return path[k] + velocity[k] * beyond;  // also of an instant that is no number
    const double slope = (path[k] - position_at(time, path, velocity, back)) / (time[k] - back);
    return path[k] + (2 * velocity[k] - slope) * beyond;
  }
  const double length = time[k + 1] - time[k], u = (instant - time[k]) / length, v = 1 - u;
  return v * v * (1 + 2 * u) * path[k] + u * u * (3 - 2 * u) * path[k + 1] +
         length * u * v * (v * velocity[k] - u * velocity[k + 1]);
}

double noise_of_path(const Eigen::ArrayXd& time, const Eigen::ArrayXd& recorded, double log_resolution) {
  if (!has_path(time)) return 0;
  return std::max(noise_of(time, recorded, log_resolution), log_resolution / std::sqrt(12.0));
}

double noise_between(const LogColumn& column, const Eigen::ArrayXd& time) {
  if (!column.samples || column.samples->time.empty() || time.size() == 0) return 0;
  const std::vector<double>& stamps = column.samples->time;
  double squares = 0;
  std::size_t next = 0;
  for (const double t : time) {
    while (next + 1 < stamps.size() && stamps[next] < t) ++next;
    const double u =
        next > 0 ? std::clamp((stamps[next] - t) / (stamps[next] - stamps[next - 1]), 0.0, 1.0) : 0;
    const Eigen::Array4d weights{-u * (1 - u) * (2 - u) / 6, (1 - u * u) * (2 - u) / 2,
                                 u * (1 + u) * (2 - u) / 2, -u * (1 - u * u) / 6};
    squares += weights.square().sum();
  }
  const auto array = [](const std::vector<double>& x) -> Eigen::ArrayXd {
    return Eigen::Map<const Eigen::ArrayXd>(x.data(), static_cast<Eigen::Index>(x.size()));
  };
  return noise_of_path(array(stamps), array(column.samples->value), 0) *
         std::sqrt(squares / static_cast<double>(time.size()));
}

SmoothPath smooth_path(const Eigen::ArrayXd& time, const Eigen::ArrayXd& recorded, double log_resolution,
                       bool smooth_rates) {
  const Eigen::Index n = recorded.size();
  if (!has_path(time)) return {recorded, Eigen::ArrayXd::Zero(n), {}, 0, 0};
  const double differences = noise_of_path(time, recorded, log_resolution);
  const double interval = common_interval(time);
  // The least of several estimates is low; what a window leaves that distorts nothing is a better one.
  double noise = differences;
  std::vector<Window> windows;
  bool fast = !smooth_rates && interval > 0;
  for (const Eigen::Index h : half_windows) {
    if (2 * h + 1 > n / 3) break;
    Window next(time, recorded, h, interval);
    if (!windows.empty()) {
      const double left = next.residual_noise();
      if (left > distorted_of(n) * differences) break;
      if (!windows.back().is_line() && next.distorts(windows.back(), noise)) break;
      noise = std::max(noise, left);
    }
    fast = fast && windows.empty();
    windows.push_back(std::move(next));
  }
  if (windows.empty()) return {recorded, Eigen::ArrayXd::Zero(n), {}, noise, noise};
  const Window widest = std::move(windows.back());
  windows.pop_back();
  if (fast) return with_interpolated_rates(time, recorded, interval, widest, noise);
  return widest.path(noise, windows);
}

namespace {

/// Whether a residual is no more than white noise, nor its means over `rows_of_mean` rows, which show less of
/// a distortion: both within four standard deviations of a sum of squares.
bool is_noise(const Eigen::ArrayXd& residual, double noise) {
  constexpr Eigen::Index rows_of_mean = 16;
  const auto exceeds = [](double squares, double variance, Eigen::Index count) {
    return squares >
           variance * (static_cast<double>(count) + 4 * std::sqrt(2.0 * static_cast<double>(count)));
  };
  const Eigen::Index means = residual.size() / rows_of_mean;
  double of_means = 0;
  for (Eigen::Index i = 0; i < means; ++i)
    of_means += std::pow(residual.segment(i * rows_of_mean, rows_of_mean).mean(), 2);
  return !exceeds(residual.square().sum(), noise * noise, residual.size()) &&
         !exceeds(of_means, noise * noise / rows_of_mean, means);
}

}  // namespace

Eigen::ArrayXd sectioned_path(const Eigen::ArrayXd& time, const Eigen::ArrayXd& recorded,
                              const Eigen::ArrayXd& smooth, double noise) {
  constexpr Eigen::Index least = 32;  // rows: fewer than those of the widest windows have no less noise
  Eigen::ArrayXd path = smooth;
  std::vector<std::pair<Eigen::Index, Eigen::Index>> sections{{0, recorded.size()}};  // first row, rows
  while (!sections.empty()) {  // halves of halves, of finitely many rows
    const auto [first, rows] = sections.back();
    sections.pop_back();
    if (rows < least) continue;
    const Eigen::ArrayXd t = time.segment(first, rows), x = recorded.segment(first, rows);
    const double half = 0.5 * (t[rows - 1] - t[0]);
    if (!(half > 0)) continue;
    const Eigen::ArrayXd u = (t - t[0]) / half - 1;
    Eigen::MatrixXd powers(rows, 4);
    powers << Eigen::VectorXd::Ones(rows), u.matrix(), u.square().matrix(), u.cube().matrix();
    const Eigen::VectorXd from_first = (x - x[0]).matrix();
    const Eigen::ArrayXd fitted =
        (powers * solve_symmetric(powers.transpose() * powers, powers.transpose() * from_first)).array();
    const Eigen::ArrayXd residual = from_first.array() - fitted;
    if (is_noise(residual, noise)) {
      path.segment(first, rows) = x[0] + fitted;
      continue;
    }
    // A corner of the motion is where a cubic across it errs most. With an eighth at least on each side the
    // number of sections is a logarithm.
    Eigen::Index split = 0;
    residual.segment(rows / 8, rows - rows / 4).abs().maxCoeff(&split);
    split += rows / 8;
    sections.emplace_back(first, split);
    sections.emplace_back(first + split, rows - split);
  }
  return path;
}

Eigen::ArrayXd direction_of_motion(const Eigen::ArrayXd& path, double threshold) {
  Eigen::ArrayXd direction = Eigen::ArrayXd::Zero(path.size());
  Eigen::Index low = 0, high = 0;  // rows of the lowest and highest position since the last reversal
  double present = 0;
  for (Eigen::Index k = 0; k < path.size(); ++k) {
    if (path[k] <= path[low]) low = k;
    if (path[k] >= path[high]) high = k;
    const bool rose = present <= 0 && path[k] > path[low] + threshold;
    const bool fell = present >= 0 && path[k] < path[high] - threshold;
    if (rose || fell) {
      // The reversal is at the extreme position, not where it exceeds the threshold.
      const Eigen::Index reversal = rose ? low : high;
      present = rose ? 1 : -1;
      direction.segment(reversal + 1, k - reversal).setConstant(present);
      low = high = k;
    }
    direction[k] = present;
  }
  return direction;
}

Eigen::ArrayXd direction_with_readings(const Eigen::ArrayXd& path, const Eigen::ArrayXd& measured,
                                       Eigen::ArrayXd direction, double still, double step) {
  const Eigen::Index n = path.size();
  Eigen::Index searched = 0;  // up to here: each standstill is looked through once, also if it trembles
  for (Eigen::Index k = 1; k < n; ++k) {
    if (direction[k] == direction[k - 1] || k <= searched) continue;
    const double before = direction[k - 1], after = direction[k];
    Eigen::Index first = k - 1, last = k;
    while (first > 0 && std::abs(path[first - 1] - path[k - 1]) < still) --first;
    while (last + 1 < n && std::abs(path[last + 1] - path[k - 1]) < still) ++last;
    const double from = measured[first], to = measured[last];
    searched = last;
    if (std::abs(to - from) <= 2 * step) continue;
    for (Eigen::Index i = first; i <= last; ++i) {
      const bool still_before = std::abs(measured[i] - from) <= step,
                 already = std::abs(measured[i] - to) <= step;
      direction[i] = already ? after : still_before ? before : 0;
    }
  }
  return direction;
}

}  // namespace qerr
