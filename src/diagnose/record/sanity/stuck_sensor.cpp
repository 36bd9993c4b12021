#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "diagnose/record/smooth_path.hpp"

/// Sensors that do not follow the motion, always or for some time.
namespace qerr::sanity {

namespace {

/// Of two columns without any relation [1]: less than half a correlation, and a slope below which neither a
/// wrong ratio, nor play, nor noise of a reference that is of use explains it (convention).
constexpr double unrelated_slope = 0.02;

/// Standard deviation of measured - reference below which one is computed from the other [counts]: a
/// thirtieth of what quantization leaves (convention).
constexpr double copied = 0.01;

/// Rows in which a signal does not change by more than a width: first, and one past the last.
struct ConstantRun {
  Eigen::Index first, end;
};

/// In a motion, as many as rows: they are visited, not collected.
template <class Visit>
void visit_constant_runs(const Eigen::ArrayXd& signal, double width, Visit visit) {
  for (Eigen::Index first = 0, end = 0; first < signal.size(); first = end) {
    double lowest = signal[first], highest = lowest;
    for (; end < signal.size(); ++end) {
      lowest = std::min(lowest, signal[end]), highest = std::max(highest, signal[end]);
      if (highest - lowest > width) break;
    }
    visit(ConstantRun{first, end});
  }
}

/// A reference that stands, and what the encoder does meanwhile.
struct StandingReference {
  ConstantRun rows;
  double motion;  ///< peak to peak [counts]; 0 if a single step makes it, which is no motion
  double net;     ///< from its first row to its last [counts]
};

StandingReference standing(const ConstantRun& run, const Eigen::ArrayXd& counts) {
  const Eigen::Index n = run.end - run.first;
  const auto read = counts.segment(run.first, n);
  const double motion = peak_to_peak(read),
               step = n > 1 ? (read.tail(n - 1) - read.head(n - 1)).abs().maxCoeff() : 0;
  return {run, 2 * step > motion ? 0 : motion, read[n - 1] - read[0]};
}

/// How often the motion in a standstill exceeds the error elsewhere before it is no play and no wind-up
/// against friction: both leave their whole width as an error of the rest of the record, where the joint
/// moves both ways or has moved on in the same direction; static friction that is twice the sliding one adds
/// half of it.
constexpr double beyond_play = 3;

/// Largest rise up to each row.
Eigen::ArrayXd largest_rise(const Eigen::ArrayXd& x) {
  Eigen::ArrayXd rise(x.size());
  double lowest = x[0], largest = 0;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    lowest = std::min(lowest, x[k]);
    rise[k] = largest = std::max(largest, x[k] - lowest);
  }
  return rise;
}

/// The standstills that the joint has not made.
std::vector<StandingReference> frozen(const Eigen::ArrayXd& counts, const Eigen::ArrayXd& reference) {
  std::vector<StandingReference> all;
  visit_constant_runs(reference, 0, [&](const ConstantRun& run) {
    if (run.end - run.first < 3) return;  // a single step is no motion
    if (const StandingReference s = standing(run, counts); s.motion >= missed_motion) all.push_back(s);
  });
  if (all.empty()) return {};
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;  // error elsewhere
  const auto include = [&](Eigen::Index first, Eigen::Index end) {
    for (Eigen::Index k = first; k < end; ++k) {
      lowest = std::min(lowest, counts[k] - reference[k]);
      highest = std::max(highest, counts[k] - reference[k]);
    }
  };
  Eigen::Index end = 0;
  for (const StandingReference& s : all) {
    include(end, s.rows.first);
    end = s.rows.end;
  }
  include(end, reference.size());
  const auto less = [](const StandingReference& a, const StandingReference& b) {
    return a.motion < b.motion;
  };
  std::stable_sort(all.begin(), all.end(), less);
  const Eigen::Index last = reference.size() - 1;
  const Eigen::ArrayXd rise = largest_rise(reference), fall = largest_rise(-reference);
  const bool both_ways = std::min(rise[last], fall[last]) >= missed_motion;
  const auto goes_on = [&](const StandingReference& s) {
    const bool one_way = std::abs(s.net) >= s.motion - 2;
    return one_way && (s.net > 0 ? rise : fall)[s.rows.first] >= missed_motion;
  };
  for (auto s = all.begin(); s != all.end(); ++s) {
    if ((both_ways || goes_on(*s)) && s->motion > beyond_play * (highest - lowest)) return {s, all.end()};
    include(s->rows.first, s->rows.end);
  }
  return {};
}

/// Changes between two counts that are no chance (convention).
constexpr Eigen::Index fewest_changes = 4;

Eigen::Index changes_in(const ConstantRun& run, const Eigen::ArrayXd& counts) {
  const Eigen::Index n = run.end - run.first - 1;
  return n < 1 ? 0 : (counts.segment(run.first + 1, n) != counts.segment(run.first, n)).count();
}

/// Motion of the reference that a stuck sensor misses during a run, 0 if the sensor is not stuck [counts].
///
/// A stuck sensor makes up for the motion with a jump at the end of the run. After a gap in the record, or
/// where counts are lost, it does not; a counter that goes to and fro between two counts, as one channel of a
/// quadrature encoder makes it, has no need to: no play does that.
/// @param least  smallest difference of two values of the reference that is a motion [counts]
double missed_in(const ConstantRun& run, const Eigen::ArrayXd& counts, const Eigen::ArrayXd& reference,
                 double least) {
  const Eigen::Index n = counts.size();
  if (run.end - run.first < 5) return 0;
  const double moved = reference[std::min(run.end, n - 1)] - reference[run.first];
  const double jump = run.end < n ? counts[run.end] - counts[run.first] : moved;
  // Motion after the last row of the run may be a gap in the record.
  const double within = std::abs(reference[run.end - 1] - reference[run.first]);
  // A reading that is ahead in time rests first, and at the end of the record its reference arrives there.
  const auto error = [&](Eigen::Index k) { return std::abs(counts[k] - reference[k]); };
  if (run.end == n && error(n - 1) < error(run.first)) return 0;
  const bool catches_up = jump * moved > 0 && std::abs(jump - moved) < 0.2 * std::abs(moved) + 2;
  const bool has_end = run.end < n || run.first == 0 || run.end - run.first > n / 100;
  const bool stuck = within >= std::max(0.5 * missed_motion, least) &&
                     std::abs(moved) >= std::max(missed_motion, least) &&
                     (catches_up || changes_in(run, counts) >= fewest_changes) && has_end;
  return stuck ? std::max(std::abs(moved), within) : 0;
}

}  // namespace

void check_constant_columns(Sanity& s, std::size_t encoder) {
  const auto read = recorded_counts(s, encoder);
  const auto column = s.log.find(LogSignal::reference, encoder);
  if (!read) return;
  const double resolution = s.model.transmission.encoders[encoder].resolution;
  const double travel = peak_to_peak(read->counts);
  if (column && (s.log.values.col(*column) == s.log.values(0, *column)).all() && travel >= missed_motion) {
    s.warnings.push_back(s.log.columns[static_cast<std::size_t>(*column)].header +
                         ": constant, while the encoder moves by " + significant(travel, 4) +
                         " counts: the column is not used");
    drop_column(s.log, *column);
    return;
  }
  const Eigen::ArrayXd reference = encoder_reference(s, encoder);
  if (column && reference.size() > 0 && travel >= missed_motion) {
    // Columns that differ in some rows are no copies: most records end here.
    if (standard_deviation(some_rows(read->counts) - some_rows(reference) / resolution) >= copied) return;
    const double differs = standard_deviation(read->counts - reference / resolution);
    if (differs >= copied) return;
    s.data.push_back(
        {"the reference is a copy of the readings: it differs from them by " + significant(differs, 2) +
             " counts (standard deviation), and quantization alone leaves 0.29 of any other sensor",
         s.model.chain.independent[encoder].name,
         1,
         {},
         "record a sensor of its own as the reference; if it is one, the encoder is finer than in "
         "the spec",
         DataKind::contradictory});
    drop_column(s.log, *column);
    return;
  }
  if (reference.size() == 0 || travel > 0 || peak_to_peak(reference) < missed_motion * resolution) return;
  s.unexplained.push_back({s.model.chain.independent[encoder].name,
                           "the encoder is constant while its reference moves",
                           {},
                           {},
                           peak_to_peak(reference)});
  s.warnings.push_back(s.log.columns[static_cast<std::size_t>(read->column)].header +
                       ": constant: no verdict on this joint");
  drop_column(s.log, read->column);
}

void check_unrelated(Sanity& s, std::size_t encoder) {
  const auto column = s.log.find(LogSignal::reference, encoder);
  if (!column || !has_counts(s, encoder) || !has_reference(s, encoder) ||
      s.log.values.rows() < fewest_rows_of_slope)
    return;
  const auto read = recorded_counts(s, encoder);
  const double resolution = s.model.transmission.encoders[encoder].resolution;
  const Eigen::ArrayXd reference = reference_in_counts(s, encoder);
  // A slope that some rows have beyond chance.
  if (std::abs(fit_line(some_rows(reference), some_rows(read->counts)).slope) > 10 * unrelated_slope) return;
  if (peak_to_peak(read->counts) < missed_motion || peak_to_peak(reference) < missed_motion) return;
  const Line line = fit_line(reference, read->counts);
  const double explained = std::abs(line.slope) * standard_deviation(reference);
  if (std::abs(line.slope) > unrelated_slope || explained > line.residual_rms / std::sqrt(3.0)) return;
  const std::string& joint = s.model.chain.independent[encoder].name;
  s.unexplained.push_back({joint,
                           "the reference does not follow the encoder",
                           {},
                           {},
                           rms(read->counts - reference) * resolution});
  s.data.push_back(
      {"the reference varies by " + significant(standard_deviation(reference), 3) +
           " counts (standard deviation), the encoder by " +
           significant(standard_deviation(read->counts), 3) + ", and they are not correlated",
       joint,
       1,
       {},
       "no verdict on this joint: look whether the column is that of another joint, or noise of an "
       "input without a sensor",
       DataKind::contradictory});
  drop_column(s.log, *column);
}

void check_frozen_reference(Sanity& s, std::size_t encoder) {
  if (!has_counts(s, encoder) || !has_reference(s, encoder) || !s.log.find(LogSignal::reference, encoder))
    return;
  const Eigen::ArrayXd reference = reference_in_counts(s, encoder);
  const std::vector<StandingReference> all = frozen(recorded_counts(s, encoder)->counts, reference);
  if (all.empty()) return;
  std::vector<char> left_out(static_cast<std::size_t>(reference.size()));
  for (const StandingReference& still : all)
    std::fill(left_out.begin() + still.rows.first, left_out.begin() + still.rows.end, 1);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < reference.size(); ++k)
    if (!left_out[static_cast<std::size_t>(k)]) kept.push_back(k);
  const Eigen::Index first = all.back().rows.first;
  s.data.push_back(
      {"the reference stands still while the encoder moves by " + significant(all.back().motion, 4) +
           " counts, and elsewhere it follows: " + counted(left_out.size() - kept.size(), "row") + " at " +
           counted(all.size(), "place") + " are left out",
       s.model.chain.independent[encoder].name, s.log.row_number(first) + 1, time_of(s, first),
       "look for lost messages of the reference sensor, or for an end of its range", DataKind::repeated});
  keep_rows(s, kept);
}

void check_stuck_sensor(Sanity& s, std::size_t encoder) {
  if (!has_counts(s, encoder) || !has_reference(s, encoder) || !s.log.has_time()) return;
  const auto read = recorded_counts(s, encoder);
  const double resolution = s.model.transmission.encoders[encoder].resolution;
  const Eigen::ArrayXd reference = reference_in_counts(s, encoder);
  const Eigen::Index n = read->counts.size();
  std::vector<ConstantRun> stuck;
  double missed = 0;
  ConstantRun longest{};
  const auto search = [&](double least) {
    constexpr double one_count = 1.5;
    stuck.clear(), missed = 0;
    visit_constant_runs(read->counts, one_count, [&](const ConstantRun& run) {
      const double here = missed_in(run, read->counts, reference, least);
      if (here > missed) missed = here, longest = run;
      if (here > 0) stuck.push_back(run);
    });
  };
  search(0);
  if (missed == 0) return;
  // Most records end above. The difference of two values has sqrt 2 times their noise, of which four
  // deviations are exceeded in 6e-5 of the rests.
  const Eigen::ArrayXd time = s.log.values.col(*s.log.find(LogSignal::time));
  search(4 * std::sqrt(2.0) * noise_of_path(time, reference, 0));
  if (missed == 0) return;
  std::vector<Eigen::Index> kept;  // of a run that is stuck, the first row
  Eigen::Index k = 0;
  for (const ConstantRun& run : stuck) {
    while (k <= run.first) kept.push_back(k++);
    k = run.end;
  }
  while (k < n) kept.push_back(k++);
  const LogColumn& column = s.log.columns[static_cast<std::size_t>(read->column)];
  const Eigen::Index since = longest.first;
  const auto excluded = static_cast<std::size_t>(n) - kept.size();
  if (column.held > 0) {  // the sensor may have been read, and not recorded
    s.data.push_back({"the encoder has no value while its reference moves by " + significant(missed, 4) +
                          " counts: " + counted(excluded, "row") + ", in which its last one is held, " +
                          (excluded == 1 ? "is" : "are") + " excluded",
                      s.model.chain.independent[encoder].name, s.log.row_number(since) + 1, time_of(s, since),
                      "record the encoder without interruption", DataKind::missing});
    keep_rows(s, kept);
    return;
  }
  const bool toggles = changes_in(longest, read->counts) >= fewest_changes;
  const std::string does = toggles ? "goes to and fro between two counts" : "is constant";
  s.unexplained.push_back({s.model.chain.independent[encoder].name,
                           "the encoder " + does + " for some time" +
                               (toggles           ? ", as with one channel of a quadrature encoder dead"
                                : longest.end < n ? ", then jumps to its reference"
                                                  : ", to the end of the record"),
                           {},
                           {},
                           missed * resolution});
  s.warnings.push_back(column.header + ": " + does + " from " + significant(*time_of(s, since), 4) +
                       " s on while its reference moves by " + significant(missed, 4) +
                       " counts: " + std::to_string(excluded) + " rows are excluded");
  keep_rows(s, kept);
}

}  // namespace qerr::sanity
