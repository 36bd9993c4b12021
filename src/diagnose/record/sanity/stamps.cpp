#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"

/// The column of time: effects of time are only as good as its stamps.
namespace qerr::sanity {

namespace {

/// Stamps that an even clock gives when it is written with too few decimals: the clock is taken instead.
/// @returns whether they are even
bool restore_even_clock(Sanity& s, Eigen::Index column, const Eigen::ArrayXd& index, const Line& clock) {
  auto time = s.log.values.col(column);
  const double grid = s.log.columns[static_cast<std::size_t>(column)].step(), interval = clock.slope;
  const Eigen::ArrayXd even = clock.intercept + interval * index;
  const double off = (time - even).abs().maxCoeff();
  if (off < 1e-3 * interval) return true;
  if (off > 0.75 * grid || grid > 20 * interval) return false;
  s.warnings.push_back("time: stamps are written on a grid of " + significant(grid, 4) + " s, samples are " +
                       significant(interval, 4) + " s apart: even stamps are taken in their place");
  time = even;
  return true;
}

}  // namespace

void check_stamps(Sanity& s) {
  const auto column = s.log.find(LogSignal::time);
  if (!column) return;
  const Eigen::Index n = s.log.values.rows();
  Eigen::ArrayXd index(n);
  for (Eigen::Index k = 0; k < n; ++k) index[k] = static_cast<double>(s.log.row_number(k));
  const Line clock = fit_line(index, s.log.values.col(*column));
  if (!(clock.slope > 0)) {
    s.warnings.push_back("time: all stamps are the same: nothing that depends on time can be judged");
    drop_column(s.log, *column);
    return;
  }
  if (restore_even_clock(s, *column, index, clock)) return;
  const Eigen::ArrayXd time = s.log.values.col(*column);
  const Eigen::ArrayXd steps =
      (time.tail(n - 1) - time.head(n - 1)) / (index.tail(n - 1) - index.head(n - 1));
  const double middle = median({steps.begin(), steps.end()}), usual = middle > 0 ? middle : clock.slope;
  const auto same = (steps == 0).count(), gaps = (steps > 5 * usual).count();
  if (same > 0)
    s.warnings.push_back("time: " + std::to_string(same) + " of " + std::to_string(n) +
                         " rows have the stamp of the row before: their velocity is not known");
  if (gaps > 0)
    s.warnings.push_back("time: " + std::to_string(gaps) + " gaps, the longest of " +
                         significant(steps.maxCoeff(), 4) + " s where " + significant(usual, 4) +
                         " s are usual");
  Eigen::ArrayXd within = (steps > 5 * usual).select(usual, steps);
  if (standard_deviation(within) > 0.02 * usual) {
    s.warnings.push_back("time: stamps are uneven, " + significant(within.minCoeff(), 4) + " to " +
                         significant(within.maxCoeff(), 4) + " s apart (mean " +
                         significant(within.mean(), 4) + " s, standard deviation " +
                         significant(standard_deviation(within), 4) +
                         " s); they are taken as they stand, a filter at a constant rate does not");
    return;
  }
  const Eigen::Index half = (n - 1) / 2;
  const double first = within.head(half).mean(), second = within.tail(half).mean();
  if (gaps == 0 && std::abs(second / first - 1) > 1e-4)
    s.warnings.push_back("time: the interval between stamps changes by " +
                         significant(1e6 * (second / first - 1), 4) +
                         " ppm from the first half to the second: one of the clocks drifts");
}

}  // namespace qerr::sanity
