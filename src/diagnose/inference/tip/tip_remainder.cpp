#include "diagnose/inference/tip/tip_remainder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/random.hpp"
#include "core/statistics.hpp"
#include "diagnose/search/peaks.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index fewest_rows_in_time = 24, fewest_draws = 40;
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

/// What changes at one row and persists, as a target that was knocked.
struct Shift {
  Eigen::Index row = 0;
  Eigen::RowVectorXd by;  ///< of the rows after it from those before [m]
  double share = 0;       ///< of the variance
};

Shift largest_shift(const Eigen::MatrixXd& left) {
  const Eigen::MatrixXd centred = left.rowwise() - left.colwise().mean();
  const double whole = centred.squaredNorm(), n = static_cast<double>(left.rows());
  Eigen::RowVectorXd before = Eigen::RowVectorXd::Zero(left.cols());
  Shift best{0, Eigen::RowVectorXd::Zero(left.cols()), 0};
  if (!(whole > 0)) return best;
  // A few rows at an end are no shift, but where a motion or a play begins.
  const Eigen::Index fewest = std::clamp<Eigen::Index>(left.rows() / 8, 1, 8);
  for (Eigen::Index k = 1; k <= left.rows() - fewest; ++k) {
    before += centred.row(k - 1);
    if (k < fewest) continue;
    const double rows = static_cast<double>(k), both = rows * (n - rows) / n;
    const double share = before.squaredNorm() / both / whole;
    if (share > best.share) best = {k, -before / both, share};
  }
  return best;
}

Eigen::MatrixXd without(Eigen::MatrixXd left, const Shift& shift) {
  left.bottomRows(left.rows() - shift.row).rowwise() -= shift.by;
  return left;
}

/// The rows' time; poses without stamps are listed in the order in which they were taken.
Eigen::ArrayXd time_of(const TipEvidence& e) {
  if (!e.ordered) return Eigen::ArrayXd::LinSpaced(e.rows(), 0, static_cast<double>(e.rows() - 1));
  return e.encoders.front().time - e.encoders.front().time[0];
}

Unidentified described(const Shift& shift, const TipEvidence& e) {
  Unidentified u{"tip", "a step in time", {}, {}, shift.by.norm(), Shape::step};
  u.figures = {{"size", shift.by.norm()}};
  if (e.ordered)
    u.figures["time"] = e.encoders.front().time[shift.row];
  else
    u.what += ", from pose " + std::to_string(shift.row + 1) + " on";
  u.next = "look whether the target was knocked or the tracker moved then, and record again";
  return u;
}

/// Shares of the variance in the strongest bands and in the largest shift.
struct Shares {
  std::array<Band, widths.size()> bands;
  std::array<double, widths.size()> in_band{};
};

Shares shares(const std::vector<double>& power) {
  Shares s;
  const double whole = sum(power);
  for (std::size_t i = 0; i < widths.size(); ++i) {
    s.bands[i] = strongest_band(power, widths[i]);
    s.in_band[i] = s.bands[i].power / whole;
  }
  return s;
}

/// The first width whose strongest band has more than chance has; none: widths.size().
std::size_t structured(const Shares& s, const std::array<double, widths.size()>& limits) {
  for (std::size_t i = 0; i < widths.size(); ++i)
    if (s.in_band[i] >= beyond_surrogates * limits[i] && s.in_band[i] >= noticeable) return i;
  return widths.size();
}

}  // namespace

std::vector<Unidentified> tip_remainder(const TipModel& m, const Eigen::MatrixXd& left) {
  const TipEvidence& e = m.evidence();
  if (e.rows() < fewest_rows_in_time || !(rms(left.reshaped()) > computed_tip)) return {};
  const Eigen::ArrayXd time = time_of(e);
  const double duration = time[time.size() - 1];
  if (!(duration > 0)) return {};
  const double spacing = std::numbers::pi / (2 * duration);
  std::array<double, widths.size()> limits{};
  double limit_of_shift = 0;
  const std::uint64_t noise = stream_seed(m.seed(), "tip remainder");
  for (Eigen::Index d = 0; d < std::max(fewest_draws, m.surrogates().cols()); ++d) {
    Eigen::VectorXd drawn = Eigen::VectorXd::Zero(m.entries().size());
    if (d < m.surrogates().cols()) drawn = m.surrogates().col(d);
    // Uniform numbers: the power of a frequency is a sum over all rows.
    for (Eigen::Index k = 0; k < drawn.size(); ++k)
      drawn[k] +=
          m.solution().sigma * std::sqrt(12.0) *
          (unit_interval(random_bits(noise, static_cast<std::uint64_t>(k), static_cast<std::uint64_t>(d))) -
           0.5);
    const Eigen::MatrixXd by_chance = m.in_base(drawn);
    const Shares s = shares(spectrum(by_chance, time, spacing));
    for (std::size_t i = 0; i < widths.size(); ++i) limits[i] = std::max(limits[i], s.in_band[i]);
    limit_of_shift = std::max(limit_of_shift, largest_shift(by_chance).share);
  }
  const std::vector<double> power = spectrum(left, time, spacing);
  const Shares found = shares(power);
  const std::size_t i = structured(found, limits);
  const Shift shift = largest_shift(left);
  const bool shifted = shift.share >= beyond_surrogates * limit_of_shift && shift.share >= noticeable;
  if (shifted && structured(shares(spectrum(without(left, shift), time, spacing)), limits) == widths.size())
    return {described(shift, e)};
  if (i == widths.size()) return {};  // also of an exact fit
  const double frequency = centre(power, found.bands[i], widths[i]) * spacing / (2 * std::numbers::pi);
  // Of the variance of all coordinates, which is that of a line of this amplitude along one of them.
  const double variance = left.squaredNorm() / static_cast<double>(left.rows());
  Unidentified u{"tip", "changes slowly in time", {}, {}, std::sqrt(2 * found.in_band[i] * variance)};
  if (frequency * duration > 3 && e.ordered) {
    u.what = "vibrates";
    u.frequency = frequency;
    u.shape = Shape::line;
    u.figures = {{"frequency", frequency}};
  } else if (!e.ordered) {
    u.what = "changes from pose to pose in their order, slowly";
  }
  return {u};
}

std::vector<Unidentified> wandering_tracker(const TipModel& alone, const TipModel& causes) {
  const TipEvidence& e = alone.evidence();
  const Eigen::Index knots = std::clamp<Eigen::Index>(e.rows() / 16, 2, 9);
  constexpr double most_of_it = 0.5;  // of the variance
  if (e.rows() < fewest_rows_in_time || causes.frames().size() + causes.size() == 0) return {};
  const Eigen::MatrixXd left = alone.in_base(alone.solution().residual);
  const Eigen::ArrayXd place = time_of(e) * (static_cast<double>(knots - 1) / time_of(e).maxCoeff());
  Eigen::MatrixXd hats(e.rows(), knots);
  for (Eigen::Index i = 0; i < knots; ++i)
    hats.col(i) = (1 - (place - static_cast<double>(i)).abs()).cwiseMax(0).matrix();
  const Eigen::MatrixXd normal = hats.transpose() * hats;
  const Eigen::MatrixXd wander = hats * normal.ldlt().solve(hats.transpose() * left);
  const double whole = (left.rowwise() - left.colwise().mean()).squaredNorm(),
               rest = (left - wander).squaredNorm(), by_causes = causes.solution().residual.squaredNorm();
  // Schwarz's criterion; twice, as neighbouring rows are not independent.
  const auto entries = static_cast<double>(left.size());
  const auto more = static_cast<double>(wander.cols() * (knots - 1) - causes.frames().size() - causes.size());
  const double gained = 0.5 * entries * std::log(by_causes / rest),
               price = std::log(entries) * std::max(more, 4.0);
  if (rest > (1 - most_of_it) * whole || !(gained > price)) return {};
  const Eigen::MatrixXd about = wander.rowwise() - wander.colwise().mean();
  Unidentified u{"tip",
                 e.ordered ? "changes slowly in time" : "changes from pose to pose in their order, slowly",
                 {},
                 {},
                 std::sqrt(2 * about.squaredNorm() / static_cast<double>(left.rows()))};
  u.next =
      "look whether the tracker warms up or its mount gives way: track a point that rests beside the tip";
  return {u};
}

std::vector<Unidentified> displaced_target(const TipModel& alone, double left_by_causes) {
  const TipEvidence& e = alone.evidence();
  if (e.rows() < fewest_rows_in_time || e.axes.size() < 3) return {};
  constexpr double most_of_it = 0.5;  // of the variance: the causes of less are not looked for here
  Eigen::MatrixXd left = alone.in_base(alone.solution().residual);
  for (const bool of_target : {false, true}) {
    if (of_target)  // in the axes of the tip, with which the target moves
      for (Eigen::Index k = 0; k < left.rows(); ++k)
        left.row(k) = (left.row(k) * alone.estimate().pose(e, k).tool).eval();
    const Shift shift = largest_shift(left);
    const double rest = without(left, shift).squaredNorm() / static_cast<double>(left.size());
    if (shift.share > most_of_it && std::sqrt(rest) < left_by_causes) return {described(shift, e)};
  }
  return {};
}

}  // namespace qerr
