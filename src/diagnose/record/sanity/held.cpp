#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "diagnose/record/smooth_path.hpp"

namespace qerr::sanity {

/// Sensors that are read less often than the log has rows: the log repeats their last value.

namespace {

/// Updates that a judgement needs. A live sensor has a held update only where its reference errs by five
/// standard deviations (6e-7 of the updates), so that a majority of 32 is never chance.
constexpr int fewest_updates = 32;
constexpr double held_deviations = 5;

/// Share of the updates in the same phase of the period from which rows at that phase are fresh, those at
/// rest included; the rest allows for gaps of the record.
constexpr double in_phase = 0.95;

struct Hold {
  int rows = 0;            ///< median between two updates
  Eigen::Index first = 0;  ///< row of the first value that is held
  std::vector<Eigen::Index> fresh;
};

/// A signal and the motion that it should follow, in counts.
struct Followed {
  const Eigen::ArrayXd &signal, &motion;
  double quantum = 1;  ///< step of the signal
  double slack = 0;    ///< error of a difference of the motion
};

/// A change of a signal, and the motion since the change before.
struct Update {
  double travel = 0;
  int rows = 0;
  bool held = false;
};

/// A live sensor of step q changes before the motion exceeds q. A held one stays while the motion exceeds it,
/// and its next value makes up for all of the motion; after backlash or a stop by friction it does not.
/// @param visit  is called with each update but the first, and its row
template <class Visit>
void visit_updates(const Followed& f, Visit visit) {
  const double least = f.quantum + f.slack;
  Eigen::Index last = 0;
  for (Eigen::Index k = 1; k < f.signal.size(); ++k) {
    if (f.signal[k] == f.signal[k - 1]) continue;
    if (last > 0) {
      const double travel = f.motion[k] - f.motion[last];
      // A twentieth of the travel: errors of scale.
      const bool held = std::abs(travel) > 2 * least && std::abs(f.motion[k - 1] - f.motion[last]) > least &&
                        std::abs(f.signal[k] - f.signal[last] - travel) < 2 * least + 0.05 * std::abs(travel);
      visit(Update{std::abs(travel), static_cast<int>(k - last), held}, k);
    }
    last = k;
  }
}

std::optional<Hold> hold_of(const Sanity& s, const Followed& f) {
  std::map<int, int> held;  // number of held updates by rows since the previous one
  Hold h;
  int count = 0, below = 0;
  visit_updates(f, [&](const Update& update, Eigen::Index k) {
    if (!update.held) return;
    ++held[update.rows];
    if (count++ == 0) h.first = k - update.rows;
  });
  if (count < fewest_updates) return std::nullopt;
  for (const auto& [rows, updates] : held)
    if (below <= count / 2) h.rows = rows, below += updates;
  // A change that comes sooner than a hold of these rows would at its speed is of a live sensor: noise of the
  // readings now and then repeats a value, too.
  double telling = 0, stale = 0;
  visit_updates(f, [&](const Update& update, Eigen::Index k) {
    const double in_hold = update.travel * std::max(1.0, static_cast<double>(h.rows) / update.rows);
    if (in_hold > 2 * (f.quantum + f.slack)) telling += update.travel;
    if (update.held) stale += update.travel;
    if (h.fresh.empty()) h.fresh.push_back(k - update.rows);
    h.fresh.push_back(k);
  });
  if (stale < 0.5 * telling) return std::nullopt;
  // Where all updates have one phase, rows at rest in this phase are fresh, too.
  const auto phase = [&](Eigen::Index k) {
    return static_cast<std::size_t>(s.log.row_number(k) % static_cast<std::uint64_t>(h.rows));
  };
  std::vector<double> phases(static_cast<std::size_t>(h.rows));
  for (const Eigen::Index k : h.fresh) ++phases[phase(k)];
  const auto usual = std::max_element(phases.begin(), phases.end());
  if (*usual < in_phase * static_cast<double>(h.fresh.size())) return h;
  h.fresh.clear();
  for (Eigen::Index k = 0; k < f.signal.size(); ++k)
    if (phase(k) == static_cast<std::size_t>(usual - phases.begin())) h.fresh.push_back(k);
  return h;
}

/// The finding. Rows with fresh values have no age, so that nothing else is to be said of it. Where qerr
/// itself has held the values between their samples, the record has no fault.
void report_hold(Sanity& s, const Hold& h, std::size_t encoder, LogSignal held, const std::string& signal) {
  const auto time = s.log.values.col(*s.log.find(LogSignal::time));
  const double interval = (time[time.size() - 1] - time[0]) / static_cast<double>(time.size() - 1);
  const double period = h.rows * interval, age = 0.5 * (h.rows - 1) * interval;
  const auto column = s.log.find(held, encoder);
  const bool by_reader = column && s.log.columns[static_cast<std::size_t>(*column)].held > 0;
  const bool several = signal == "counts";
  const std::string old = readable(age, "s") + " old in the mean, which is no latency of the sensor";
  s.data.push_back(
      {"the " + signal +
           (by_reader ? several ? " have a sample every " : " has a sample every "
            : several ? " are held for "
                      : " is held for ") +
           std::to_string(h.rows) + " rows (" + readable(period, "s") +
           (by_reader ? "), which is held between them as the log is read" : ")") +
           ": only the rows with a fresh value are judged",
       s.model.chain.independent[encoder].name, s.log.row_number(h.first) + 1, time[h.first],
       by_reader ? "record all signals at one rate: a held one is " + old
                 : "log at the rate of the sensor, or stamp its values when they are read; until then the " +
                       signal + " of the log " + (several ? "are " : "is ") + old,
       by_reader ? DataKind::remark : DataKind::repeated});
}

/// Between the samples of another file its noise is alike from row to row, and would not show.
double noise_of_reference(const Sanity& s, std::size_t encoder, const Eigen::ArrayXd& reference) {
  const Eigen::ArrayXd time = s.log.values.col(*s.log.find(LogSignal::time));
  const auto column = s.log.find(LogSignal::reference, encoder);
  const auto rows =
      column ? s.log.rows_at_samples(static_cast<std::size_t>(*column)) : std::vector<Eigen::Index>{};
  return rows.empty() ? noise_of_path(time, reference, 0) : noise_of_path(time(rows), reference(rows), 0);
}

std::optional<Hold> check_held(Sanity& s, std::size_t encoder) {
  if (!has_counts(s, encoder) || !s.log.has_time() || s.log.values.rows() < fewest_updates)
    return std::nullopt;
  const auto read = recorded_counts(s, encoder);
  const double step = s.model.transmission.encoders[encoder].resolution;
  const Eigen::ArrayXd reference = reference_in_counts(s, encoder);
  if (reference.size() == 0) return std::nullopt;
  // First: steps of a held reference would be taken for its noise.
  if (auto h = hold_of(s, {reference, read->counts, s.reference_grid[encoder] / step, 1})) {
    report_hold(s, *h, encoder, LogSignal::reference, "reference");
    return h;
  }
  const double noise = noise_of_reference(s, encoder, reference);
  auto h = hold_of(s, {read->counts, reference, 1, held_deviations * std::sqrt(2.0) * noise});
  if (h) report_hold(s, *h, encoder, read->direct ? LogSignal::counts : LogSignal::measured, "counts");
  return h;
}

}  // namespace

void check_held_cells(Sanity& s) {
  for (const LogColumn& c : s.log.columns) {
    const bool position = c.signal == LogSignal::counts || c.signal == LogSignal::measured ||
                          c.signal == LogSignal::reference || c.signal == LogSignal::tip;
    if (position && c.held > 0)
      s.data.push_back(
          {c.header + " has no value of its own in " + counted(c.held, "row") +
               ", where its last one is held as the log is read: late there if it moves",
           c.signal == LogSignal::tip ? "tip" : s.model.chain.independent[c.index].name,
           {},
           {},
           "where cells are empty because nothing was recorded, and not because nothing changed, "
           "state log: {missing: drop}"});
  }
}

void check_held_sensors(Sanity& s) {
  std::vector<Eigen::Index> fresh;
  bool held = false;
  for (std::size_t i = 0; i < s.model.transmission.encoders.size(); ++i) {
    const auto h = check_held(s, i);
    if (!h) continue;
    std::vector<Eigen::Index> common;
    if (held)
      std::set_intersection(fresh.begin(), fresh.end(), h->fresh.begin(), h->fresh.end(),
                            std::back_inserter(common));
    // Sensors that are read in turns have no fresh rows in common; each needs a log of its own.
    if (held && 2 * common.size() < std::min(fresh.size(), h->fresh.size())) {
      s.warnings.push_back(s.model.chain.independent[i].name +
                           ": its values are not fresh in the rows in which another joint's are: no verdict "
                           "on this joint");
      drop_column(s.log, recorded_counts(s, i)->column);
    } else {
      fresh = held ? std::move(common) : h->fresh;
      held = true;
    }
  }
  if (!held) return;
  keep_rows(s, fresh);
  // A filter's output at a part of the rows cannot be compared with the filter.
  for (std::size_t i = 0; i < s.model.chain.independent.size(); ++i)
    if (const auto velocity = s.log.find(LogSignal::velocity, i)) drop_column(s.log, *velocity);
}

namespace {

constexpr std::ptrdiff_t long_hold = 8;  ///< rows of a hold that is a fault of its own (convention)

/// Whether a joint has moved by a good part of its way from one row to another before the row ahead of it.
bool moved_on_the_way(const Log& log, Eigen::Index from, Eigen::Index to) {
  constexpr double steps = 3, part = 0.3;
  return std::any_of(log.columns.begin(), log.columns.end(), [&](const LogColumn& c) {
    const bool position = c.signal == LogSignal::counts || c.signal == LogSignal::measured ||
                          (c.signal == LogSignal::reference && !log.find(LogSignal::counts, c.index) &&
                           !log.find(LogSignal::measured, c.index));
    if (!position) return false;
    const auto column = log.values.col(&c - log.columns.data());
    const double early = std::abs(column[to - 1] - column[from]), all = std::abs(column[to] - column[from]);
    return early > steps * (c.signal == LogSignal::counts ? 1 : c.step()) && early > part * all;
  });
}

/// Rows [first, second) in which all coordinates of a tracker repeat those of the row before, while the
/// joints move: its next value makes up for it, by more than two of the least changes of a coordinate.
std::vector<std::pair<Eigen::Index, Eigen::Index>> held_rows(const Log& log,
                                                             const std::vector<Eigen::Index>& axes) {
  constexpr double makes_up = 2.5;
  const Eigen::Index n = log.values.rows();
  std::vector<double> least;
  for (const Eigen::Index axis : axes) {
    const Eigen::ArrayXd change = (log.values.col(axis).tail(n - 1) - log.values.col(axis).head(n - 1)).abs();
    const double rounding = 0.5 * log.columns[static_cast<std::size_t>(axis)].step();
    least.push_back((change > rounding).select(change, std::numeric_limits<double>::infinity()).minCoeff());
  }
  const auto changed = [&](Eigen::Index from, Eigen::Index to, double steps) {
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (std::abs(log.values(to, axes[i]) - log.values(from, axes[i])) > steps * least[i]) return true;
    return false;
  };
  std::vector<std::pair<Eigen::Index, Eigen::Index>> held;
  Eigen::Index last = 0;
  for (Eigen::Index k = 1; k < n; ++k) {
    if (!changed(last, k, 0.5)) continue;
    if (k > last + 1 && last > 0 && changed(last, k, makes_up) && moved_on_the_way(log, last, k))
      held.emplace_back(last + 1, k);
    last = k;
  }
  return held;
}

}  // namespace

void leave_out(Log& log, const std::vector<Eigen::Index>& columns, const std::vector<Eigen::Index>& rows) {
  const auto time = log.values.col(*log.find(LogSignal::time));
  for (const Eigen::Index column : columns) {
    auto kept = std::make_shared<ColumnSamples>();
    for (Eigen::Index k = 0; k < time.size(); ++k) {
      if (std::binary_search(rows.begin(), rows.end(), k)) continue;
      kept->time.push_back(time[k]);
      kept->value.push_back(log.values(k, column));
    }
    log.columns[static_cast<std::size_t>(column)].samples = std::move(kept);
  }
}

void check_held_tip(Sanity& s) {
  const auto stamps = s.log.find(LogSignal::time);
  std::vector<Eigen::Index> axes;
  for (std::size_t i = 0; i < 3; ++i)
    if (const auto axis = s.log.find(LogSignal::tip, i))
      if (!s.log.columns[static_cast<std::size_t>(*axis)].samples) axes.push_back(*axis);
  if (!stamps || axes.empty() || s.log.values.rows() < fewest_updates) return;
  auto held = held_rows(s.log, axes);
  std::vector<double> rows;
  for (const auto& [first, end] : held) rows.push_back(static_cast<double>(end - first + 1));
  const bool regular = static_cast<int>(held.size()) >= fewest_updates;
  if (!regular) std::erase_if(held, [](const auto& h) { return h.second - h.first < long_hold; });
  if (held.empty()) return;
  const Eigen::ArrayXd time = s.log.values.col(*stamps);
  const Eigen::Index first = held.front().first, count = held.front().second - first;
  const auto usual = static_cast<Eigen::Index>(median(rows));
  const double period =
      regular ? time[first - 1 + usual] - time[first - 1] : time[first + count] - time[first - 1];
  s.data.push_back(
      {(regular ? "its position is held for " + std::to_string(usual)
                : "its position stands still while the joints move, for " +
                      counted(static_cast<std::uint64_t>(count), "row")) +
           (regular ? " rows (" : " (") + readable(period, "s") + ")" +
           (regular || held.size() == 1 ? "" : ", the first of " + counted(held.size(), "place")) +
           ": only the rows with a fresh value are judged",
       "tip", s.log.row_number(first) + 1, time[first],
       regular ? "log at the rate of the tracker, or stamp its values when they are taken"
               : "look whether the tracker lost its target",
       DataKind::repeated});
  std::vector<Eigen::Index> repeated;
  for (const auto& [from, end] : held)
    for (Eigen::Index k = from; k < end; ++k) repeated.push_back(k);
  leave_out(s.log, axes, repeated);
}

/// References that are interpolated, by whoever made the table or as its files are joined: they have more
/// rows than readings.

namespace {

/// Knots that a judgement needs, and their least distance in the mean [rows]. Between knots a measured path
/// would be straight to the last decimal by chance only.
constexpr std::size_t fewest_knots = 16;
constexpr double least_distance = 4;

/// Rows at which a piecewise linear column bends. Empty: it is not piecewise linear.
/// @param rounding  of the values by the file: four halves of it bend a straight line
std::vector<Eigen::Index> knots_of(const Eigen::Ref<const Eigen::ArrayXd>& x, double rounding) {
  const double exact = 16 * std::numeric_limits<double>::epsilon() * x.abs().maxCoeff();
  const double straight = 2.01 * rounding + exact;
  std::vector<Eigen::Index> knots;
  Eigen::Index reversals = 0, rests = 0, last = -2;
  for (Eigen::Index k = 1; k + 1 < x.size(); ++k) {
    const double before = x[k] - x[k - 1], after = x[k + 1] - x[k];
    if (std::abs(after - before) <= straight) continue;
    reversals += before * after < 0;
    rests += before == 0 || after == 0;
    // A knot between two rows bends the path in both of them.
    const bool same = k == last + 1;
    last = k;
    if (same && k > knots.back() + 1) return {};  // a curve
    if (same) continue;
    knots.push_back(k);
    if (static_cast<double>(knots.size()) * least_distance > static_cast<double>(x.size())) return {};
  }
  // A straight path that turns back is a motion at constant speed; one that rests is a held value.
  if (knots.size() < fewest_knots || 2 * (reversals + rests) > static_cast<Eigen::Index>(knots.size()))
    return {};
  return knots;
}

/// Rows of the readings between which the reference of a joint is interpolated; empty: its rows are readings.
std::vector<Eigen::Index> rows_of_readings(const Sanity& s, std::size_t joint) {
  const auto column = s.log.find(LogSignal::reference, joint);
  if (!column) return {};
  const LogColumn& of = s.log.columns[static_cast<std::size_t>(*column)];
  if (of.samples) return s.log.rows_at_samples(static_cast<std::size_t>(*column));
  // Values on a coarse grid are straight without interpolation.
  if (s.reference_grid[joint] > 0 || of.step() > s.model.transmission.encoders[joint].resolution) return {};
  return knots_of(s.log.values.col(*column), of.step());
}

/// What polynomials of the fifth degree leave of eight samples, per degree of freedom of white noise: two,
/// the divided difference of order 7 and its first moment.
double bend_of(const double* time, const double* value) {
  constexpr int width = 8;
  Eigen::Array<double, width, 1> t = Eigen::Map<const Eigen::Array<double, width, 1>>(time), weight, x;
  t = (t - 0.5 * (t[3] + t[4])) / (t[7] - t[0]);
  x = Eigen::Map<const Eigen::Array<double, width, 1>>(value) - value[0];
  for (int i = 0; i < width; ++i) {
    double product = 1;
    for (int k = 0; k < width; ++k) product *= k == i ? 1 : t[i] - t[k];
    weight[i] = 1 / product;
  }
  const Eigen::Array<double, width, 1> moment = weight * t;
  return std::hypot((weight * x).sum() / weight.matrix().norm(), (moment * x).sum() / moment.matrix().norm());
}

/// Rows between samples of which a corner of the motion takes more from the cubic through four of them than
/// their noise and the encoder's rounding: eight samples show what no noise has. At the fraction u between
/// two samples the cubic errs across a corner by up to 0.76 u (1 - u) of the second difference there, which
/// bend_of has divided by 8.1 where it is between two of them.
std::vector<Eigen::Index> rows_at_corners(const Sanity& s, std::size_t joint) {
  constexpr std::ptrdiff_t width = 8;
  // Rows behind a reversal that no row shows must have passed it by more than a play, which they would take
  // for one that is still to be crossed.
  constexpr double error_of_bend = 0.76 * 8.1, deviations = 4, passed = 2;
  const auto column = static_cast<std::size_t>(*s.log.find(LogSignal::reference, joint));
  const auto& samples = s.log.columns[column].samples;
  const auto stamps = s.log.find(LogSignal::time);
  if (!samples || !stamps || std::ssize(samples->time) < 4 * width) return {};
  std::vector<double> bends;
  for (std::ptrdiff_t i = 0; i + width <= std::ssize(samples->time); ++i)
    bends.push_back(
        bend_of(&samples->time[static_cast<std::size_t>(i)], &samples->value[static_cast<std::size_t>(i)]));
  const double noise = median(bends) / std::sqrt(2 * std::numbers::ln2);  // of a Rayleigh distribution
  const double negligible =
      std::hypot(noise, s.model.transmission.encoders[joint].resolution / std::sqrt(12.0));
  std::vector<Eigen::Index> rows;
  std::ptrdiff_t behind = 1;
  double until = -std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < s.log.values.rows(); ++k) {
    const double time = s.log.values(k, *stamps);
    const auto at = [&](std::ptrdiff_t i) { return samples->time[static_cast<std::size_t>(i)]; };
    while (behind + 1 < std::ssize(samples->time) && at(behind) < time) ++behind;
    const double u = (time - at(behind - 1)) / (at(behind) - at(behind - 1));
    const double bend = bends[static_cast<std::size_t>(
        std::clamp<std::ptrdiff_t>(behind - width / 2, 0, std::ssize(bends) - 1))];
    if (bend > deviations * noise && error_of_bend * u * (1 - u) * bend > negligible)
      until = time + passed * (at(behind) - at(behind - 1));
    if (time <= until) rows.push_back(k);
  }
  return rows;
}

}  // namespace

void check_interpolated(Sanity& s) {
  constexpr double nearly_all = 0.75;  // of the rows, beyond which errors of neighbours are hardly alike
  const auto all = static_cast<std::size_t>(s.log.values.rows());
  std::vector<Eigen::Index> fresh, corners;
  const auto add_to = [](std::vector<Eigen::Index>& set, const std::vector<Eigen::Index>& rows) {
    std::vector<Eigen::Index> either;
    std::set_union(set.begin(), set.end(), rows.begin(), rows.end(), std::back_inserter(either));
    set = std::move(either);
  };
  for (std::size_t j = 0; j < s.model.chain.independent.size(); ++j) {
    if (!has_counts(s, j)) continue;
    const std::vector<Eigen::Index> rows = rows_of_readings(s, j);
    if (rows.empty()) continue;
    if (const std::vector<Eigen::Index> bends = rows_at_corners(s, j); !bends.empty()) {
      add_to(corners, bends);
      s.data.push_back({"in " + counted(bends.size(), "row") +
                            " the motion changes faster than the samples of the reference show: these rows "
                            "are not judged",
                        s.model.chain.independent[j].name, s.log.row_number(bends.front()) + 1,
                        time_of(s, bends.front()), "record the reference at the rate of the encoder"});
    }
    if (static_cast<double>(rows.size()) > nearly_all * static_cast<double>(all)) continue;
    add_to(fresh, rows);
    const std::size_t column = static_cast<std::size_t>(*s.log.find(LogSignal::reference, j));
    s.data.push_back({"the reference is interpolated between " + counted(rows.size(), "reading") + ": of " +
                          counted(all, "row") + " only those next to one are judged",
                      s.model.chain.independent[j].name, s.log.row_number(rows.front()) + 1,
                      time_of(s, rows.front()),
                      (s.log.columns[column].samples ? "record the reference at the rate of the encoder"
                                                     : "record the readings themselves") +
                          std::string(": between them nothing can be judged")});
  }
  if (fresh.empty() && corners.empty()) return;
  if (fresh.empty()) {
    fresh.resize(all);
    std::iota(fresh.begin(), fresh.end(), Eigen::Index{0});
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (const auto tip = s.log.find(LogSignal::tip, axis))
      add_to(fresh, s.log.rows_at_samples(static_cast<std::size_t>(*tip)));
  std::vector<Eigen::Index> kept;
  std::set_difference(fresh.begin(), fresh.end(), corners.begin(), corners.end(), std::back_inserter(kept));
  keep_rows(s, kept);
}

}  // namespace qerr::sanity
