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

/// Share of the intervals that may be whole multiples of the usual one for rows to be missing there: more of
/// them are those of stamps that are rounded to a step of about the interval (convention).
constexpr double seldom = 0.05;

/// Difference, relative to the usual interval, up to which an interval is a whole multiple of it
/// (convention).
constexpr double near_multiple = 0.1;

/// Intervals beyond which a multiple is not known: the tolerance of a clock, 50 ppm, is a tenth of one.
constexpr double most_missing = near_multiple / 50e-6;

void report_stamps(Sanity& s, const std::string& what, Eigen::Index row, const std::string& remedy,
                   DataKind kind = DataKind::remark) {
  s.data.push_back({"time: " + what, "", s.log.row_number(row) + 1, time_of(s, row), remedy, kind});
}

/// Number of usual intervals in each interval: above 1 where rows are missing between the stamps of an even
/// clock, or of a counter. All are 1 if the stamps are uneven.
Eigen::ArrayXd multiples_of(const Eigen::ArrayXd& intervals, double usual) {
  const Eigen::ArrayXd nearest = (intervals / usual).round().max(1);
  const Eigen::ArrayXd off = (intervals / usual - nearest).abs();
  const Eigen::ArrayXd multiples = (off < near_multiple && nearest < most_missing).select(nearest, 1);
  const auto longer = static_cast<double>((multiples > 1).count());
  const bool even = rms((multiples == nearest).select(off, 0)) < uneven;
  return even && longer <= seldom * static_cast<double>(intervals.size())
             ? multiples
             : Eigen::ArrayXd::Ones(intervals.size());
}

/// The rows that are missing, and gaps of unknown length.
void report_gaps(Sanity& s, const Eigen::ArrayXd& intervals, const Eigen::ArrayXd& multiples, double usual) {
  const auto is_gap = [&](Eigen::Index k) { return multiples[k] > 1 || intervals[k] > gap * usual; };
  std::size_t gaps = 0;
  Eigen::Index first = 0, longest = 0;
  for (Eigen::Index k = intervals.size(); k-- > 0;) {
    if (!is_gap(k)) continue;
    ++gaps, first = k;
    if (longest == 0 || !is_gap(longest) || intervals[k] > intervals[longest]) longest = k;
  }
  if (gaps == 0) return;
  const auto missing = static_cast<std::size_t>(multiples.sum()) - static_cast<std::size_t>(multiples.size());
  report_stamps(s,
                counted(gaps, "gap") +
                    (missing > 0 ? ", in which " + counted(missing, "row") + (missing == 1 ? " is" : " are") +
                                       " missing"
                                 : "") +
                    ", the longest of " + significant(intervals[longest], 4) + " s; the usual interval is " +
                    significant(usual, 4) + " s",
                first + 1, "record without interruption: motion within a gap is unknown", DataKind::missing);
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

/// Repeated and uneven stamps, and a rate that changes.
/// @param step  of the stamps [s]
void check_intervals(Sanity& s, const Eigen::ArrayXd& intervals, double usual, double step) {
  const Eigen::Index n = intervals.size() + 1;
  if (const auto same = (intervals == 0).count(); same > 0)
    report_stamps(s,
                  std::to_string(same) + " of " + std::to_string(n) +
                      " rows have the stamp of the previous row: their velocity is unknown",
                  first_row(intervals, [](double by) { return by == 0; }),
                  "stamp each reading when it is taken, with enough decimals", DataKind::repeated);
  const Eigen::ArrayXd within = (intervals > gap * usual).select(usual, intervals);
  const double deviation = standard_deviation(within);
  if (deviation > uneven * usual) {
    report_stamps(
        s,
        "stamps are uneven, " + significant(within.minCoeff(), 4) + " to " +
            significant(within.maxCoeff(), 4) + " s apart (mean " + significant(within.mean(), 4) +
            " s, standard deviation " + significant(deviation, 4) + " s); they are used as recorded",
        first_row(within, [&](double by) { return std::abs(by - usual) > uneven * usual; }),
        "if the readings are taken at a constant rate, stamp them with the sensor's clock; a filter "
        "assumes a constant rate");
    return;
  }
  const Eigen::Index half = (n - 1) / 2;
  // A doubled or a late stamp is none of the clock's rate.
  const auto rate_of = [&](const Eigen::ArrayXd& part) {
    const auto regular = ((part - usual).abs() < near_multiple * usual).cast<double>().eval();
    return (part * regular).sum() / std::max(1.0, regular.sum());
  };
  const double change = rate_of(within.tail(half)) / rate_of(within.head(half)) - 1;
  // A mean of intervals errs by those of its first and last stamp: by a step at most, and by their scatter.
  const double error = (2 * step + 6 * deviation) / (static_cast<double>(half) * usual);
  if ((intervals <= gap * usual).all() && std::abs(change) > clock_drift + error)
    report_stamps(s,
                  "the interval between stamps changes by " + significant(1e6 * change, 4) +
                      " ppm from the first half to the second: one of the clocks drifts",
                  half, "stamp with a disciplined clock");
}

/// Mean interval from which rows may be single poses: a robot does not settle in less [s] (convention).
constexpr double least_dwell = 0.25;

/// Counts from row to row that are motion, whatever quantization and noise add (convention).
constexpr double least_step = 8;

/// Whether the motion between the rows is not sampled: in most rows a joint moves on, and in most of these
/// its step is another one than the last.
bool has_single_poses(const Sanity& s, double interval) {
  if (interval < least_dwell) return false;
  std::vector<Eigen::ArrayXd> counts;
  for (std::size_t i = 0; i < s.model.transmission.encoders.size(); ++i)
    if (const auto read = recorded_counts(s, i)) counts.push_back(read->counts);
  Eigen::Index moving = 0, bent = 0;
  const Eigen::Index n = s.log.values.rows();
  for (Eigen::Index k = 1; k + 1 < n; ++k) {
    double step = 0, bend = 0;
    for (const Eigen::ArrayXd& c : counts)
      if (const double of_this = std::max(std::abs(c[k] - c[k - 1]), std::abs(c[k + 1] - c[k]));
          of_this > step)
        step = of_this, bend = std::abs(c[k + 1] - 2 * c[k] + c[k - 1]);
    if (step < least_step) continue;
    ++moving;
    bent += bend > 0.5 * step;
  }
  return 2 * moving > n && 3 * bent > 2 * moving;
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
                  "record the time of each reading", DataKind::repeated);
    drop_column(s.log, *column);
    return;
  }
  if (has_single_poses(s, clock.slope)) {
    report_stamps(s,
                  "the rows are single poses, " + significant(clock.slope, 2) +
                      " s apart, whose motion is not sampled: the stamps are not used",
                  0, "record the motion between them, if effects of speed or direction are of interest",
                  DataKind::remark);
    drop_column(s.log, *column);
    return;
  }
  if (restore_even_clock(s, *column, index, clock)) return;
  const Eigen::ArrayXd time = s.log.values.col(*column);
  const Eigen::ArrayXd rows_apart = index.tail(n - 1) - index.head(n - 1);
  Eigen::ArrayXd intervals = (time.tail(n - 1) - time.head(n - 1)) / rows_apart;
  const double middle = median({intervals.begin(), intervals.end()});
  const double usual = middle > 0 ? middle : clock.slope;
  // Missing rows first: without them the stamps may be even.
  const Eigen::ArrayXd multiples = multiples_of(intervals, usual);
  report_gaps(s, intervals, multiples, usual);
  if ((multiples > 1).any()) {
    for (Eigen::Index k = 1; k < n; ++k) index[k] = index[k - 1] + rows_apart[k - 1] * multiples[k - 1];
    if (restore_even_clock(s, *column, index, fit_line(index, time))) return;
    intervals /= multiples;
  }
  check_intervals(s, intervals, usual, s.log.columns[static_cast<std::size_t>(*column)].step());
}

}  // namespace qerr::sanity
