#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "diagnose/record/smooth_path.hpp"

/// References that are coarser or noisier than the encoder that they judge.
namespace qerr::sanity {

namespace {

/// Values without a grid lie within `grid_tolerance` of a whole number of steps in one of five cases, so that
/// 64 changes of several steps are never chance.
constexpr double grid_tolerance = 0.1;
constexpr int fewest_changes = 64;

/// Part of a count below which a grid of the reference is not looked for: its rounding has 4 % of the
/// variance of that of the counts.
constexpr double negligible_grid = 0.2;

/// Changes of up to `most` steps, over some rows: their mean step, and how many are of several steps.
struct Changes {
  double step = 0;
  int several = 0;
  bool on_grid = true;
};

Changes changes_of(const Eigen::ArrayXd& x, double step, double most) {
  Changes c;
  double product = 0, square = 0;
  for (const Eigen::Index rows : {1, 8, 64, 512})
    for (Eigen::Index k = rows; k < x.size(); k += rows) {
      const double by = std::abs(x[k] - x[k - rows]), steps = std::round(by / step);
      if (by == 0 || steps > most) continue;
      if (std::abs(by / step - steps) > grid_tolerance) return {0, 0, false};
      product += by * steps, square += steps * steps;
      c.several += steps > 1;
    }
  c.step = square > 0 ? product / square : 0;
  return c;
}

/// At constant speed all changes are alike without a grid.
bool is_varied(const Eigen::ArrayXd& x, double step) {
  constexpr int fewest = 32;
  const Eigen::ArrayXd by = (x.tail(x.size() - 1) - x.head(x.size() - 1)).abs();
  return (by > 1.5 * step || by < 0.5 * step).count() >= fewest &&
         ((by - by.mean()).abs() > 0.5 * step).count() >= fewest;
}

/// Where a row is missing of a motion at constant speed, changes are multiples of that of a row. Between its
/// neighbours in time the value is then where the motion is; on a grid it is off by half a step at each
/// change.
bool is_off_motion(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x, double step) {
  constexpr int fewest = 32;
  constexpr double off = 0.25;  // of a step
  int count = 0;
  for (Eigen::Index k = 1; k + 1 < x.size(); ++k) {
    const double part = (time[k] - time[k - 1]) / (time[k + 1] - time[k - 1]);
    count += std::abs(x[k] - x[k - 1] - part * (x[k + 1] - x[k - 1])) > off * step;
  }
  return count >= fewest;
}

/// A step, refined by larger and larger changes; 0 if they are no multiples of it.
double refined_step(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x, double step) {
  int several = 0;
  for (double most = 4; most <= 1024; most *= 4) {
    const Changes c = changes_of(x, step, most);
    if (!c.on_grid) return 0;
    if (c.step > 0) step = c.step;
    several = c.several;
  }
  return several >= fewest_changes && is_varied(x, step) && is_off_motion(time, x, step) ? step : 0;
}

/// Step of a column whose values are on a grid coarser than `least`; else 0. The smallest change is one step
/// or a few.
double grid_of(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x, double least) {
  double smallest = 1e300;
  for (Eigen::Index k = 1; k < x.size(); ++k)
    if (const double by = std::abs(x[k] - x[k - 1]); by > 0 && by < smallest)
      if ((smallest = by) < least) return 0;
  if (smallest == 1e300) return 0;
  for (const double steps : {1.0, 2.0, 3.0}) {
    if (smallest / steps < least) break;
    if (const double step = refined_step(time, x, smallest / steps); step > 0) return step;
  }
  return 0;
}

/// Ascending gaps of more than `least` between neighbours in value.
Eigen::ArrayXd gaps_of(Eigen::ArrayXd x, double least) {
  std::ranges::sort(x);
  Eigen::ArrayXd gaps = x.tail(x.size() - 1) - x.head(x.size() - 1);
  std::ranges::sort(gaps);
  return gaps.tail((gaps > least).count()).eval();
}

/// Whether nearly all gaps are of as many steps, as those of positions in even steps are.
/// @param gaps  ascending
bool are_alike(const Eigen::ArrayXd& gaps, double step) {
  constexpr double nearly_all = 0.95;
  Eigen::Index same = 0, most = 0;
  for (Eigen::Index i = 0; i < gaps.size(); ++i) {
    same = i > 0 && std::round(gaps[i] / step) == std::round(gaps[i - 1] / step) ? same + 1 : 1;
    most = std::max(most, same);
  }
  return static_cast<double>(most) > nearly_all * static_cast<double>(gaps.size());
}

/// Step of a table's values, whose rows have no order: the greatest common divisor of the gaps between
/// neighbours in value (Euclid), refined by each larger gap. 0: it is less than `least`, or of even steps.
double grid_of_table(const Eigen::ArrayXd& x, double least) {
  constexpr Eigen::Index fewest_gaps = 20;  // each meets a grid by chance in one of five cases
  const double off = grid_tolerance * least;
  const Eigen::ArrayXd gaps = gaps_of(x, off);
  if (gaps.size() < fewest_gaps) return 0;
  double step = gaps[0], product = 0, square = 0;
  for (const double gap : gaps) {
    double left = std::abs(std::remainder(gap, step));
    if (left > off) product = square = 0;
    while (left > off) step = std::exchange(left, std::abs(std::remainder(step, left)));
    if (step < least) return 0;
    const double steps = std::round(gap / step);
    product += gap * steps, square += steps * steps;
    step = product / square;
  }
  return are_alike(gaps, step) ? 0 : step;
}

/// The positions of a table in even steps, of which its values are no more than rounded; else empty. Rounded
/// even steps beat with their grid, which would pass for a periodic error.
Eigen::ArrayXd even_steps(const Eigen::ArrayXd& x, double grid) {
  const Eigen::Index n = x.size();
  const std::vector<Eigen::Index> rows = ascending_rows(x);
  const Eigen::ArrayXd rank = Eigen::ArrayXd::LinSpaced(n, 0, static_cast<double>(n - 1)), sorted = x(rows);
  const Line line = fit_line(rank, sorted);
  if ((sorted - line.intercept - line.slope * rank).abs().maxCoeff() > (0.5 + grid_tolerance) * grid)
    return {};
  Eigen::ArrayXd positions(n);
  for (Eigen::Index k = 0; k < n; ++k)
    positions[rows[static_cast<std::size_t>(k)]] = line.intercept + line.slope * rank[k];
  return positions;
}

const char* unit_of_joint(const Sanity& s, std::size_t joint) {
  return s.model.chain.independent[joint].prismatic() ? "m" : "rad";
}

}  // namespace

void check_reference_grid(Sanity& s, std::size_t encoder) {
  const Eigen::ArrayXd reference = encoder_reference(s, encoder);
  if (reference.size() < 2 || !has_counts(s, encoder)) return;
  const double step = s.model.transmission.encoders[encoder].resolution, least = negligible_grid * step;
  const auto stamps = s.log.find(LogSignal::time);
  double grid =
      stamps ? grid_of(s.log.values.col(*stamps), reference, least) : grid_of_table(reference, least);
  // Rounding has the variance of its step.
  if (are_chosen_in_steps(s, encoder, reference, std::pow(grid / step, 2) / 12)) grid = 0;
  s.reference_grid[encoder] = grid;
  if (grid < step) return;
  const auto column = s.log.find(LogSignal::reference, encoder);
  if (!stamps && column && (s.log.values.col(*column) == reference).all())
    if (const Eigen::ArrayXd even = even_steps(reference, grid); even.size() > 0)
      s.log.values.col(*column) = even;
  s.data.push_back({"the reference changes in steps of " + readable(grid, unit_of_joint(s, encoder)) + " = " +
                        significant(grid / step, 3) + " counts: it is coarser than the encoder",
                    s.model.chain.independent[encoder].name,
                    1,
                    {},
                    "with it only errors of more than " + significant(grid / step, 2) +
                        " counts can be judged, no noise and no quantization: use a finer sensor, or write "
                        "more decimals"});
}

void check_reference_noise(Sanity& s, std::size_t encoder) {
  const auto stamps = s.log.find(LogSignal::time);
  if (!stamps || !has_counts(s, encoder) || s.log.values.rows() < 64 || s.reference_grid[encoder] > 0) return;
  const Eigen::ArrayXd reference = encoder_reference(s, encoder);
  const Encoder& model = s.model.transmission.encoders[encoder];
  if (reference.size() == 0 || is_static(reference, model.resolution)) return;
  const Eigen::ArrayXd time = s.log.values.col(*stamps);
  const double of_reference = noise_of_path(time, reference, 0);
  // Where the reference's variance exceeds that of the quantization, most of the residual is not the
  // encoder's.
  if (of_reference < sigma(model)) return;
  // Motion that is too fast for the rows looks like noise, but the encoder follows it.
  const double noise =
      std::min(of_reference,
               noise_of_path(time, recorded_counts(s, encoder)->counts * model.resolution - reference, 0));
  if (noise < sigma(model)) return;
  // The amplitude of a periodic error has the standard error sigma sqrt(2/n); four of them are no chance.
  const double counts = noise / model.resolution,
               visible = 4 * counts * std::sqrt(2 / static_cast<double>(reference.size()));
  s.data.push_back({"the reference has noise of " + readable(noise, unit_of_joint(s, encoder)) + " = " +
                        significant(counts, 2) +
                        " counts (standard deviation): it is coarser than the encoder",
                    s.model.chain.independent[encoder].name,
                    1,
                    {},
                    "with it only errors that repeat can be judged, from about " + significant(visible, 1) +
                        " counts on in the mean of all rows, and no noise of the encoder: use a better "
                        "sensor, or move more slowly"});
}

}  // namespace qerr::sanity
