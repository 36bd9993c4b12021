#include "diagnose/inference/tip/tip_remainder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/random.hpp"
#include "diagnose/search/peaks.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index fewest_ordered_rows = 200;
constexpr std::array<std::size_t, 2> widths{16, 160};  // of windows: frequencies are a quarter of 1/T apart
constexpr double beyond_surrogates = 1.5;              // chance has 1 in 40 already without it
constexpr double noticeable = 0.05;  // of the variance: what is less is no error to look for

/// Power by frequency, summed over the coordinates.
std::vector<double> spectrum(const Eigen::MatrixXd& series, const Eigen::ArrayXd& time, double spacing) {
  const auto last = static_cast<Eigen::Index>(2 * series.rows());
  std::vector<double> power(static_cast<std::size_t>(last));
  for (Eigen::Index c = 0; c < series.cols(); ++c) {
    const Eigen::ArrayXd centred = series.col(c).array() - series.col(c).mean();
    const std::vector<float> one = periodogram(centred, time, spacing, 1, last);
    for (std::size_t i = 0; i < power.size(); ++i) power[i] += static_cast<double>(one[i]);
  }
  return power;
}

double sum(const std::vector<double>& power) { return std::accumulate(power.begin(), power.end(), 0.0); }

struct Band {
  std::size_t first = 0;
  double power = 0;
};

Band strongest_band(const std::vector<double>& power, std::size_t width) {
  double inside = 0;
  Band best;
  for (std::size_t i = 0; i < power.size(); ++i) {
    inside += power[i] - (i >= width ? power[i - width] : 0);
    if (inside > best.power) best = {i + 1 >= width ? i + 1 - width : 0, inside};
  }
  return best;
}

/// Mean index of the power in a window.
double centre(const std::vector<double>& power, const Band& w, std::size_t width) {
  double inside = 0, moment = 0;
  for (std::size_t i = w.first; i < std::min(w.first + width, power.size()); ++i) {
    inside += power[i];
    moment += power[i] * static_cast<double>(i + 1);
  }
  return moment / inside;
}

}  // namespace

std::vector<Unidentified> tip_remainder(const TipModel& m, const Eigen::MatrixXd& left) {
  const TipEvidence& e = m.evidence();
  if (!e.ordered || e.rows() < fewest_ordered_rows) return {};
  const Eigen::ArrayXd time = e.encoders.front().time - e.encoders.front().time[0];
  const double duration = time[time.size() - 1];
  if (!(duration > 0)) return {};
  const double spacing = std::numbers::pi / (2 * duration);
  const std::vector<double> power = spectrum(left, time, spacing);
  std::array<double, widths.size()> limits{};
  const std::uint64_t noise = stream_seed(m.seed(), "tip remainder");
  for (Eigen::Index d = 0; d < m.surrogates().cols(); ++d) {
    Eigen::VectorXd drawn = m.surrogates().col(d);
    // Uniform numbers: the power of a frequency is a sum over all rows.
    for (Eigen::Index k = 0; k < drawn.size(); ++k)
      drawn[k] +=
          m.solution().sigma * std::sqrt(12.0) *
          (unit_interval(random_bits(noise, static_cast<std::uint64_t>(k), static_cast<std::uint64_t>(d))) -
           0.5);
    const std::vector<double> by_chance = spectrum(m.in_base(drawn), time, spacing);
    for (std::size_t i = 0; i < widths.size(); ++i)
      limits[i] = std::max(limits[i], strongest_band(by_chance, widths[i]).power / sum(by_chance));
  }
  const double whole = sum(power);
  for (std::size_t i = 0; i < widths.size(); ++i) {
    const Band w = strongest_band(power, widths[i]);
    const double share = w.power / whole;
    if (!(share >= beyond_surrogates * limits[i] && share >= noticeable)) continue;  // also of an exact fit
    const double frequency = centre(power, w, widths[i]) * spacing / (2 * std::numbers::pi);
    // Of the variance of all coordinates, which is that of a line of this amplitude along one of them.
    const double variance = left.squaredNorm() / static_cast<double>(left.rows());
    Unidentified found{"tip", "changes slowly in time", {}, {}, std::sqrt(2 * share * variance)};
    if (frequency * duration > 3) {
      found.what = "vibrates";
      found.frequency = frequency;
      found.shape = Shape::line;
      found.figures = {{"frequency", frequency}};
    }
    return {found};
  }
  return {};
}

}  // namespace qerr
