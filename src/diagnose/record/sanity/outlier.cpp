#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"

/// Single readings far off their neighbours.
namespace qerr::sanity {

namespace {

/// Of the median filter: it keeps a step of the error, and removes up to three readings in a row.
constexpr Eigen::Index half = 3, window = 2 * half + 1;

/// Deviations from the median of seven that no noise has: four times what noise adds to the 95 % quantile of
/// quantization alone (0.9 counts), which the outliers themselves (at most 1 %) cannot reach, and two counts
/// for the quantization. Of a Gaussian of many counts that is 7.8 standard deviations, exceeded once in 1e14
/// rows; of exponential tails once in 2e5.
constexpr double outlier_quantile = 0.95, outlier_factor = 4, outlier_counts = 2, of_quantization = 0.9;

/// Jitter scatters in proportion to the speed: deviations are compared with those at the same speed.
/// Classes of speed: below one count a row, and by powers of two.
constexpr int classes = 16;
constexpr std::size_t fewest_of_class = 200;  ///< ten of them lie beyond the quantile

double median_of_window(const Eigen::ArrayXd& x, Eigen::Index first) {
  std::array<double, window> w;
  std::copy_n(x.data() + first, window, w.begin());
  std::nth_element(w.begin(), w.begin() + half, w.end());
  return w[half];
}

Eigen::Index first_of_window(Eigen::Index k, Eigen::Index rows) {
  return std::clamp<Eigen::Index>(k - half, 0, rows - window);
}

/// Distance from the median of the window. At both ends of the record a row is up to three rows beside the
/// middle of its window, and a smooth error changes by as many of its steps.
double deviation(const Eigen::ArrayXd& error, Eigen::Index k) {
  const Eigen::Index first = first_of_window(k, error.size());
  const double off = std::abs(error[k] - median_of_window(error, first));
  const auto beside = static_cast<double>(std::abs(k - first - half));
  if (beside == 0) return off;
  std::vector<double> steps;
  for (Eigen::Index i = first + 1; i < first + window; ++i)
    steps.push_back(std::abs(error[i] - error[i - 1]));
  return std::max(0.0, off - beside * median(std::move(steps)));
}

std::size_t class_of(const Eigen::ArrayXd& motion, Eigen::Index k) {
  const Eigen::Index first = first_of_window(k, motion.size());
  const double speed = std::abs(motion[first + window - 1] - motion[first]) / (window - 1);
  return static_cast<std::size_t>(std::clamp(std::ilogb(std::max(speed, 0.5)) + 1, 0, classes - 1));
}

double upper_quantile(std::vector<double>& values) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(outlier_quantile * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Rows from which the quantiles are estimated: 1000 of them lie beyond.
constexpr Eigen::Index enough_rows_of_quantile = 20000;

/// Limit of the deviation in each class of speed [counts].
std::array<double, classes> limits(const Eigen::ArrayXd& error, const Eigen::ArrayXd& motion) {
  std::array<std::vector<double>, classes> by_speed;
  const Eigen::Index stride = std::max<Eigen::Index>(1, error.size() / enough_rows_of_quantile);
  for (Eigen::Index k = 0; k < error.size(); k += stride)
    by_speed[class_of(motion, k)].push_back(deviation(error, k));
  std::array<double, classes> limit;
  for (std::size_t c = 0; c < classes; ++c)
    limit[c] =
        by_speed[c].size() < fewest_of_class
            ? -1
            : outlier_counts + outlier_factor * std::max(0.0, upper_quantile(by_speed[c]) - of_quantization);
  const double largest = std::max(outlier_counts, *std::max_element(limit.begin(), limit.end()));
  std::replace(limit.begin(), limit.end(), -1.0, largest);  // classes with too few rows
  return limit;
}

std::vector<Eigen::Index> far_off(const Eigen::ArrayXd& error, const Eigen::ArrayXd& motion) {
  const std::array<double, classes> limit = limits(error, motion);
  const double least = *std::min_element(limit.begin(), limit.end());
  const Eigen::Index n = error.size();
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < n; ++k) {
    // What is far from the median is far from four of the six other values, so from one of any three.
    if (k >= half && k + half < n && std::abs(error[k] - error[k - 1]) <= least &&
        std::abs(error[k] - error[k + 1]) <= least && std::abs(error[k] - error[k + 2]) <= least)
      continue;
    if (deviation(error, k) > limit[class_of(motion, k)]) rows.push_back(k);
  }
  return rows;
}

/// Difference of the mean errors of both directions of motion, as a play makes it; 0 of one direction.
double hysteresis(const Eigen::ArrayXd& error, const Eigen::ArrayXd& motion) {
  Eigen::Array2d sums = Eigen::Array2d::Zero(), rows = sums;
  for (Eigen::Index k = 1; k < error.size(); ++k) {
    if (motion[k] == motion[k - 1]) continue;
    const Eigen::Index side = motion[k] > motion[k - 1] ? 1 : 0;
    sums[side] += error[k];
    ++rows[side];
  }
  return (rows > 0).all() ? std::abs(sums[1] / rows[1] - sums[0] / rows[0]) : 0;
}

/// What a reading at an end of the record may stay behind, as before a play is taken up or a drive breaks
/// loose: motion from row to row beside it, three times, as it may accelerate, and the play. 0 elsewhere.
double lag_at_end(const Eigen::ArrayXd& error, const Eigen::ArrayXd& motion, Eigen::Index first,
                  Eigen::Index end) {
  const Eigen::Index n = motion.size();
  if (first > 0 && end < n) return 0;
  const Eigen::Index from = first > 0 ? first - half : end;
  double step = 0;
  for (Eigen::Index k = std::max<Eigen::Index>(from, 0); k + 1 < std::min(from + half, n); ++k)
    step = std::max(step, std::abs(motion[k + 1] - motion[k]));
  return std::max(3 * step, hysteresis(error, motion));
}

/// Whether rows first .. end - 1 are off and the two on either side agree: else the error itself moves fast,
/// in a vibration or a step.
bool stand_alone(const Eigen::ArrayXd& error, const Eigen::ArrayXd& motion, Eigen::Index first,
                 Eigen::Index end) {
  const Eigen::Index n = error.size();
  std::vector<double> around;
  for (const Eigen::Index k : {first - 2, first - 1, end, end + 1})
    if (k >= 0 && k < n) around.push_back(error[k]);
  if (end - first > half || around.size() < 2) return false;
  const auto [low, high] = std::minmax_element(around.begin(), around.end());
  const double middle = 0.5 * (*low + *high);
  return (error.segment(first, end - first) - middle).abs().minCoeff() >
         std::max(3 * (*high - *low), lag_at_end(error, motion, first, end));
}

/// Of the rows that are far off, those that stand alone.
std::vector<Eigen::Index> alone(const Eigen::ArrayXd& error, const Eigen::ArrayXd& motion,
                                const std::vector<Eigen::Index>& rows) {
  std::vector<Eigen::Index> single;
  for (std::size_t i = 0; i < rows.size();) {
    std::size_t end = i + 1;
    while (end < rows.size() && rows[end] == rows[end - 1] + 1) ++end;
    if (stand_alone(error, motion, rows[i], rows[end - 1] + 1))
      single.insert(single.end(), rows.begin() + static_cast<std::ptrdiff_t>(i),
                    rows.begin() + static_cast<std::ptrdiff_t>(end));
    i = end;
  }
  return single;
}

/// Deviation from the line through the two neighbours.
double bend(const Eigen::ArrayXd& x, Eigen::Index k) {
  const Eigen::Index i = std::clamp<Eigen::Index>(k, 1, x.size() - 2);
  return std::abs(x[i] - 0.5 * (x[i - 1] + x[i + 1]));
}

std::vector<Eigen::Index> check_outliers(Sanity& s, std::size_t encoder) {
  const auto stamps = s.log.find(LogSignal::time);
  const Eigen::Index n = s.log.values.rows();
  if (!has_counts(s, encoder) || !has_reference(s, encoder) || !stamps ||
      n < static_cast<Eigen::Index>(fewest_of_class))
    return {};
  const auto read = recorded_counts(s, encoder);
  const Eigen::ArrayXd motion = reference_in_counts(s, encoder);
  const Eigen::ArrayXd error = read->counts - motion;
  const std::vector<Eigen::Index> rows = alone(error, motion, far_off(error, motion));
  // A hundredth of the rows and more are not single readings, but a scatter.
  if (rows.empty() || static_cast<double>(rows.size()) > 0.01 * static_cast<double>(n)) return {};
  const Eigen::Index worst = *std::max_element(
      rows.begin(), rows.end(), [&](auto a, auto b) { return deviation(error, a) < deviation(error, b); });
  const bool of_reference = bend(motion, worst) > bend(read->counts, worst);
  std::string where;
  for (std::size_t i = 1; i < std::min<std::size_t>(rows.size(), 5); ++i)
    where += (i > 1 ? ", " : "; also row ") + std::to_string(s.log.row_number(rows[i]) + 1);
  if (rows.size() > 5) where += ", ...";
  s.data.push_back({counted(rows.size(), "reading") + " of the " + (of_reference ? "reference" : "encoder") +
                        (rows.size() == 1 ? " is" : " are") + " far off the neighbours, up to " +
                        significant(deviation(error, worst), 3) + " counts" + where,
                    s.model.chain.independent[encoder].name, s.log.row_number(rows.front()) + 1,
                    s.log.values(rows.front(), *stamps),
                    "these rows are left out here; look for interference on the cable, or for lost messages",
                    DataKind::corrupt});
  return rows;
}

}  // namespace

void check_outliers(Sanity& s) {
  std::vector<char> left_out;
  for (std::size_t i = 0; i < s.model.transmission.encoders.size(); ++i)
    for (const Eigen::Index k : check_outliers(s, i)) {
      left_out.resize(static_cast<std::size_t>(s.log.values.rows()));
      left_out[static_cast<std::size_t>(k)] = 1;
    }
  if (left_out.empty()) return;
  std::vector<Eigen::Index> kept;
  for (std::size_t k = 0; k < left_out.size(); ++k)
    if (!left_out[k]) kept.push_back(static_cast<Eigen::Index>(k));
  keep_rows(s, kept);
}

}  // namespace qerr::sanity
