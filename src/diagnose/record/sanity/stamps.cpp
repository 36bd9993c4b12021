#include <algorithm>
#include <cmath>
#include <string>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"

/// Time stamps: effects that depend on time are identified only as accurately as these.
namespace qerr::sanity {

namespace {

/// Interval, relative to the usual one, that is a gap (convention).
constexpr double gap = 5;

/// Standard deviation of the intervals, relative to the usual one, above which stamps are uneven
/// (convention): a velocity that assumes a constant rate has a relative error of this size.
constexpr double uneven = 0.02;

/// Relative difference between the mean intervals of both halves that is reported as drift (convention; the
/// tolerance of a quartz oscillator is usually below 50 ppm).
constexpr double clock_drift = 1e-4;

void report_stamps(Sanity& s, const std::string& what, Eigen::Index row, const std::string& remedy) {
  s.data.push_back({"time: " + what, "", row_in_file(s, row) + 1, time_of(s, row), remedy});
}

/// First row after an interval for which `is` holds.
template <class Is>
Eigen::Index first_row(const Eigen::ArrayXd& intervals, Is is) {
  return std::find_if(intervals.begin(), intervals.end(), is) - intervals.begin() + 1;
}

/// Replaces stamps that are those of an even clock, written with too few decimals, by the exact ones.
/// @param clock  line through the stamps by row number
/// @returns whether the stamps are even
bool restore_even_clock(Sanity& s, Eigen::Index column, const Eigen::ArrayXd& index, const Line& clock) {
  auto time = s.log.values.col(column);
  const double step = s.log.columns[static_cast<std::size_t>(column)].step(), interval = clock.slope;
  const Eigen::ArrayXd even = clock.intercept + interval * index;
  const double off = (time - even).abs().maxCoeff();
  if (off < 1e-3 * interval) return true;
  // Rounding moves a stamp by half a step at most; the fitted line adds an error of its own.
  if (off > 0.75 * step || step > 20 * interval) return false;
  report_stamps(s,
                "stamps are multiples of " + significant(step, 4) + " s, samples are " +
                    significant(interval, 4) + " s apart: replaced by even stamps",
                0, "write more decimals");
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
    report_stamps(s, "all stamps are the same: no verdict on effects that depend on time", 0,
                  "record the time of each reading");
    drop_column(s.log, *column);
    return;
  }
  if (restore_even_clock(s, *column, index, clock)) return;
  const Eigen::ArrayXd time = s.log.values.col(*column);
  const Eigen::ArrayXd intervals =
      (time.tail(n - 1) - time.head(n - 1)) / (index.tail(n - 1) - index.head(n - 1));
  const double middle = median({intervals.begin(), intervals.end()});
  const double usual = middle > 0 ? middle : clock.slope;
  const auto same = (intervals == 0).count(), gaps = (intervals > gap * usual).count();
  if (same > 0)
    report_stamps(s,
                  std::to_string(same) + " of " + std::to_string(n) +
                      " rows have the stamp of the previous row: their velocity is unknown",
                  first_row(intervals, [](double by) { return by == 0; }),
                  "stamp each reading when it is taken, with enough decimals");
  if (gaps > 0)
    report_stamps(s,
                  counted(static_cast<std::size_t>(gaps), "gap") + ", the longest of " +
                      significant(intervals.maxCoeff(), 4) + " s; the usual interval is " +
                      significant(usual, 4) + " s",
                  first_row(intervals, [&](double by) { return by > gap * usual; }),
                  "record without interruption: motion within a gap is unknown");
  const Eigen::ArrayXd within = (intervals > gap * usual).select(usual, intervals);
  if (standard_deviation(within) > uneven * usual) {
    report_stamps(
        s,
        "stamps are uneven, " + significant(within.minCoeff(), 4) + " to " +
            significant(within.maxCoeff(), 4) + " s apart (mean " + significant(within.mean(), 4) +
            " s, standard deviation " + significant(standard_deviation(within), 4) +
            " s); they are used as recorded",
        first_row(within, [&](double by) { return std::abs(by - usual) > uneven * usual; }),
        "if the readings are taken at a constant rate, stamp them with the sensor's clock; a filter "
        "assumes a constant rate");
    return;
  }
  const Eigen::Index half = (n - 1) / 2;
  const double change = within.tail(half).mean() / within.head(half).mean() - 1;
  if (gaps == 0 && std::abs(change) > clock_drift)
    report_stamps(s,
                  "the interval between stamps changes by " + significant(1e6 * change, 4) +
                      " ppm from the first half to the second: one of the clocks drifts",
                  half, "stamp with a disciplined clock");
}

}  // namespace qerr::sanity
