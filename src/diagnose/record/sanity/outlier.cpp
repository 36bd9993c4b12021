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

constexpr Eigen::Index half = 3;  ///< of the window of the median filter

/// A deviation from the median of seven that no noise has: 10 median absolute deviations are 6.7 standard
/// deviations, which a Gaussian exceeds once in 5e10 rows; and three counts.
constexpr double deviations = 10, counts = 3;

double median_of_window(const Eigen::ArrayXd& x, Eigen::Index k) {
  std::array<double, 2 * half + 1> w;
  for (Eigen::Index i = -half; i <= half; ++i) w[static_cast<std::size_t>(i + half)] = x[k + i];
  std::nth_element(w.begin(), w.begin() + half, w.end());
  return w[half];
}

}  // namespace

void check_outliers(Sanity& s, std::size_t encoder) {
  auto read = recorded_counts(s, encoder);
  const Eigen::ArrayXd reference = encoder_reference(s, encoder);
  const auto stamps = s.log.find(LogSignal::time);
  const Eigen::Index n = s.log.values.rows();
  if (!read || reference.size() == 0 || !stamps || n < 64) return;
  const double step = s.model.transmission.encoders[encoder].resolution;
  const Eigen::ArrayXd error = read->counts - reference / step;
  Eigen::ArrayXd off = Eigen::ArrayXd::Zero(n), middle = error;
  std::vector<double> sizes;
  for (Eigen::Index k = half; k + half < n; ++k) {
    middle[k] = median_of_window(error, k);
    off[k] = std::abs(error[k] - middle[k]);
    sizes.push_back(off[k]);
  }
  const double limit = deviations * median(std::move(sizes)) + counts;
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = half; k + half < n; ++k)
    if (off[k] > limit) rows.push_back(k);
  // A hundredth of the rows and more are not single readings, but a scatter.
  if (rows.empty() || static_cast<double>(rows.size()) > 0.01 * static_cast<double>(n)) return;
  Eigen::Index worst = rows.front();
  for (const Eigen::Index k : rows) {
    if (off[k] > off[worst]) worst = k;
    read->counts[k] = std::round(reference[k] / step + middle[k]);
  }
  write_back(s, *read, encoder);
  s.data.push_back({counted(rows.size(), "reading") + (rows.size() == 1 ? " is" : " are") +
                        " far off the neighbours, up to " + significant(off[worst], 3) + " counts",
                    s.model.chain.independent[encoder].name, s.log.row_number(rows.front()) + 1,
                    s.log.values(rows.front(), *stamps),
                    "they are left out here; look for interference on the cable, or for lost messages"});
}

}  // namespace qerr::sanity
