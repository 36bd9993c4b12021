#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/solve.hpp"
#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "effect/effects/effects.hpp"
#include "filter/run/cascade.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr::sanity {

/// Comparison of JOINT.velocity with filtered positions.

namespace {

/// A recorded velocity, and the positions from which the robot computed it.
struct RecordedVelocity {
  Eigen::ArrayXd time, position, velocity;
  double interval = 0;        ///< mean [s]
  double rounding_sigma = 0;  ///< rms of the velocity's rounding in the file [rad/s]

  Eigen::Index rows() const { return position.size(); }
  /// The first row that is compared: the filter has settled.
  Eigen::Index first() const { return rows() / 10; }
};

/// The `most` consecutive rows of a long record in which the velocity changes most: a filter is the same in
/// all of them, and known to the root of their number.
RecordedVelocity busiest(const RecordedVelocity& r, Eigen::Index most) {
  if (r.rows() <= most) return r;
  Eigen::Index first = 0;
  double largest = -1;
  for (Eigen::Index at = 0; at + most <= r.rows(); at += most / 2)
    if (const double size = standard_deviation(r.velocity.segment(at, most)); size > largest)
      largest = size, first = at;
  return {r.time.segment(first, most), r.position.segment(first, most), r.velocity.segment(first, most),
          r.interval, r.rounding_sigma};
}

/// Filtered positions from the first compared row on. The filter starts in the steady state of the first
/// velocity.
/// @param lead  rows of constant velocity before the record, in which it settles
Eigen::ArrayXd filtered(const RecordedVelocity& r, const Filter& filter, Eigen::Index lead = 2000) {
  const Eigen::Index n = r.rows(), first = r.first();
  Cascade<double> cascade(filter);
  Eigen::ArrayXd velocity(n - first);
  for (Eigen::Index k = -std::min(n, lead); k < n; ++k) {
    const double extrapolated = static_cast<double>(k) * r.interval * r.velocity[0];
    const double output = cascade.step(k < 0 ? extrapolated : r.position[k] - r.position[0]);
    if (k >= first) velocity[k - first] = output;
  }
  return velocity;
}

/// Recorded velocity - filtered position.
/// @param delay  of the output [samples]
Eigen::ArrayXd deviation_from(const RecordedVelocity& r, const Eigen::ArrayXd& output, Eigen::Index delay) {
  const Eigen::Index n = output.size() - delay;
  return r.velocity.tail(n) - output.head(n);
}

struct RecordedFilter {
  const FilterFamily* family = nullptr;
  int order = 0;
  double cutoff = 0;  ///< [Hz]
  Eigen::Index delay = 0;
  double misfit = 1e300;
};

Filter design(const RecordedFilter& c, double rate) {
  FilterDesign d{1, rate, {{"order", c.order}, {"cutoff", c.cutoff}}, {}, {}};
  for (const Parameter& p : c.family->parameters)
    if (p.kind == Kind::choice && !p.choices.empty()) d.choices[std::string(p.name)] = choices_of(p)[0];
  return c.family->design(d);
}

/// Logarithm of the highest cut-off that is tried: just below half the sampling rate.
double highest(const RecordedVelocity& r) { return std::log(0.45 / r.interval); }

Eigen::ArrayXd filtered(const RecordedVelocity& r, const RecordedFilter& c) {
  // Ten time constants of each of the filter's sections.
  const double memory = 10 * c.order / (2 * std::numbers::pi * c.cutoff * r.interval);
  return filtered(r, design(c, 1 / r.interval), static_cast<Eigen::Index>(std::min(2000.0, memory + 1)));
}

RecordedFilter with_cutoff(const RecordedVelocity& r, RecordedFilter c, double log_cutoff) {
  c.cutoff = std::exp(log_cutoff);
  c.misfit = rms(deviation_from(r, filtered(r, c), c.delay));
  return c;
}

/// Local search for the best cut-off, with relative steps that are halved from `first_step` down to
/// `last_step`.
RecordedFilter refined(const RecordedVelocity& r, RecordedFilter best, double first_step, double last_step) {
  for (double step = first_step; step > last_step; step /= 2)
    for (const double change : {-step, step})
      if (const double x = std::log(best.cutoff) + change; x <= highest(r))
        if (const RecordedFilter next = with_cutoff(r, best, x); next.misfit < best.misfit) best = next;
  return best;
}

/// The best cut-off of one family and order, and its delay: on a coarse grid for each delay, then by local
/// search.
RecordedFilter best_cutoff(const RecordedVelocity& r, RecordedFilter c) {
  std::array<RecordedFilter, 3> of_delays;
  const double low = std::log(1 / (2000 * r.interval)), step = (highest(r) - low) / 14;
  for (double x = low; x <= highest(r) + 1e-9; x += step) {
    c.cutoff = std::exp(x);
    const Eigen::ArrayXd output = filtered(r, c);
    for (c.delay = 0; c.delay < 3; ++c.delay) {
      c.misfit = rms(deviation_from(r, output, c.delay));
      RecordedFilter& best = of_delays[static_cast<std::size_t>(c.delay)];
      if (c.misfit < best.misfit) best = c;
    }
  }
  for (RecordedFilter& best : of_delays)
    if (best.misfit < 1e300) best = refined(r, best, step / 2, 1e-3);
  return *std::min_element(of_delays.begin(), of_delays.end(),
                           [](const auto& a, const auto& b) { return a.misfit < b.misfit; });
}

/// The filtered velocity's derivative by the logarithm of the cut-off.
Eigen::ArrayXd sensitivity_to_cutoff(const RecordedVelocity& r, const RecordedFilter& c) {
  constexpr double change = 1e-4;
  RecordedFilter other = c;
  other.cutoff *= 1 - change;
  return (filtered(r, c) - filtered(r, other)) / change;
}

/// The cut-off with its 95 % interval: residual rms over the sensitivity of the filtered velocity to the
/// cut-off. Both are correlated over the filter's memory, 1/(2 pi cutoff).
FoundParameter cutoff_parameter(const RecordedVelocity& r, const RecordedFilter& c) {
  const double sensitivity = rms(sensitivity_to_cutoff(r, c)) / c.cutoff;
  const double memory = std::max(1.0, 1 / (2 * std::numbers::pi * c.cutoff * r.interval));
  const double residual = std::max(c.misfit, r.rounding_sigma);
  const double half_width =
      1.96 * residual / sensitivity * std::sqrt(memory / static_cast<double>(r.rows() - r.first()));
  return {"cutoff", c.cutoff, c.cutoff - half_width, c.cutoff + half_width};
}

/// Found from a section, and fitted to all rows by Gauss-Newton steps.
RecordedFilter best_filter(const RecordedVelocity& r) {
  constexpr Eigen::Index enough = 4096;  // twelve time constants of the lowest cut-off that is tried
  constexpr int most_steps = 8;
  const RecordedVelocity section = busiest(r, enough);
  RecordedFilter best;
  for (const FilterFamily& family : filter_families())
    for (const int order : family.velocity_orders)
      if (const RecordedFilter c = best_cutoff(section, {&family, order}); c.misfit < best.misfit) best = c;
  if (best.misfit == 1e300) return best;
  best = with_cutoff(r, best, std::log(best.cutoff));
  for (int i = 0; i < most_steps; ++i) {
    const Eigen::ArrayXd slope = sensitivity_to_cutoff(r, best),
                         deviation = deviation_from(r, filtered(r, best), best.delay);
    const auto used = slope.head(deviation.size());
    const double x = std::log(best.cutoff) + (used * deviation).sum() / used.square().sum();
    if (!(x <= highest(r))) break;
    const RecordedFilter next = with_cutoff(r, best, x);
    if (!(next.misfit < best.misfit)) break;
    best = next;
  }
  return best;
}

/// Tests whether the differences of the positions follow the stamps instead of a constant interval, and if so
/// adds the cause, unless the spec has it.
bool follows_stamps(Sanity& s, const RecordedVelocity& r, std::size_t joint) {
  const Eigen::Index n = r.rows();
  const Eigen::ArrayXd steps = r.time.tail(n - 1) - r.time.head(n - 1);
  const Eigen::ArrayXd speed = 0.5 * (r.velocity.tail(n - 1) + r.velocity.head(n - 1));
  const Eigen::ArrayXd moved = r.position.tail(n - 1) - r.position.head(n - 1);
  const Eigen::ArrayXd constant = moved - speed * r.interval;  // residual with a constant interval [rad]
  const Eigen::ArrayXd stamped = moved - speed * steps;        // and with the recorded ones
  const Line line = fit_line(speed * (steps - r.interval), constant);
  const double before = rms(constant), after = rms(stamped);
  if (standard_deviation(steps) < 0.02 * r.interval || after > 0.5 * before || std::abs(line.slope - 1) > 0.2)
    return false;
  if (specified_effect(s, joint, timing_jitter_effect().name)) return true;
  const double sigma = standard_deviation(steps), samples = static_cast<double>(n);
  const double half_width = 1.96 * sigma / std::sqrt(2 * samples);  // normal intervals
  Cause c = exact_cause(s, joint, timing_jitter_effect().name, {{"sigma", sigma}},
                        std::exp(-samples * std::log(before / after)), before, after);
  c.parameters = {{"sigma", sigma, sigma - half_width, sigma + half_width}};
  s.causes.push_back(std::move(c));
  s.warnings.push_back(
      s.model.chain.independent[joint].name +
      ": differences of the positions follow the stamps, not a constant interval: divide them by "
      "the differences of the stamps");
  return true;
}

/// A recorded velocity that contradicts its joint, as a finding about the record and as a cause.
/// @param before, after  rms of the position that the velocity does not explain, as written and corrected
void report_fault(Sanity& s, std::size_t joint, const std::string& fault,
                  std::map<std::string, double> numbers, double before, double after, const std::string& what,
                  const std::string& remedy) {
  const LogColumn& column = s.log.columns[static_cast<std::size_t>(*s.log.find(LogSignal::velocity, joint))];
  s.data.push_back({column.header + ' ' + what,
                    s.model.chain.independent[joint].name,
                    1,
                    {},
                    remedy,
                    DataKind::contradictory});
  s.causes.push_back(
      exact_cause(s, joint, velocity_fault_effect().name, std::move(numbers), 0, before, after));
  s.causes.back().effect.choices["fault"] = fault;
}

/// A velocity with more noise than the readings have behind the spec's filter: what no filter of them leaves,
/// if it changes from row to row.
void report_noise(Sanity& s, const RecordedVelocity& r, const RecordedFilter& best, const Filter& specified,
                  std::size_t joint) {
  constexpr double more = 2;  // a velocity of the drive's own, of finer readings, has less
  const Eigen::ArrayXd rest = deviation_from(r, filtered(r, best), best.delay);
  const Eigen::Index n = rest.size();
  const bool from_row_to_row = rms(rest.tail(n - 1) - rest.head(n - 1)) > rms(rest);
  const double own = ideal_sigma(s, joint) * h2_norm(specified);
  if (!from_row_to_row || rms(rest) < more * own) return;
  const std::string unit = s.model.chain.independent[joint].prismatic() ? "m/s" : "rad/s";
  report_fault(s, joint, std::string(noise_effect().name), {{"sigma", rms(rest)}}, rms(rest) * r.interval,
               own * r.interval,
               "has noise of " + readable(rms(rest), unit) + ", and the readings behind the spec's filter " +
                   readable(own, unit),
               "state the filter that computes it under filters: if it is another one; else look for "
               "interference");
}

}  // namespace

void check_velocity(Sanity& s, const std::vector<Filter>& filters, std::size_t joint) {
  constexpr Eigen::Index enough = 1 << 16;  // rows: a filter's cut-off is known to 1e-4 and better (1 kHz)
  const auto column = s.log.find(LogSignal::velocity, joint), stamps = s.log.find(LogSignal::time);
  if (!column || !stamps || s.log.values.rows() < 200) return;
  const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, joint);
  if (!measured) return;
  const Eigen::ArrayXd time = s.log.values.col(*stamps);
  const Eigen::Index n = time.size();
  const RecordedVelocity whole{time, *measured, s.log.values.col(*column),
                               (time[n - 1] - time[0]) / static_cast<double>(n - 1), 0};
  RecordedVelocity r = busiest(whole, enough);
  const LogColumn& head = s.log.columns[static_cast<std::size_t>(*column)];
  r.rounding_sigma = head.step() / std::sqrt(12.0);
  if (rms(r.velocity) < 10 * r.rounding_sigma || peak_to_peak(r.position) < 200 * ideal_sigma(s, joint))
    return;
  double specified = 1e300, rate = 0;
  const Filter* closest = nullptr;  // of the spec
  for (const Filter& f : filters)
    if (f.derivative == 1) {
      rate = f.sample_rate;
      if (std::abs(f.sample_rate * r.interval - 1) >= 0.01) continue;
      if (const double of_this = rms(deviation_from(r, filtered(r, f), 0)); of_this < specified)
        specified = of_this, closest = &f;
    }
  // Within the rounding of the file the spec's filter computes this velocity.
  if (specified < std::max(3 * r.rounding_sigma, 1e-3 * rms(r.velocity))) return;
  if (!s.cannot_judge.empty() && follows_stamps(s, r, joint)) return;
  if (specified == 1e300) {
    if (rate > 0)
      s.warnings.push_back(head.header + ": the spec's filter runs at " + significant(rate, 6) +
                           " Hz, the log at " + significant(1 / r.interval, 6) + " Hz: not compared");
    return;
  }
  const RecordedFilter best = best_filter(r);
  if (best.misfit > 0.3 * specified || best.misfit > 0.3 * rms(r.velocity)) {
    report_noise(s, r, best, *closest, joint);
    return;
  }
  std::map<std::string, double> numbers{{"order", best.order}, {"cutoff", best.cutoff}};
  if (best.delay > 0) numbers["delay"] = static_cast<double>(best.delay) * r.interval;
  Cause c = exact_cause(s, joint, filter_mismatch_effect().name, std::move(numbers),
                        std::exp(-0.1 * static_cast<double>(r.rows()) * std::log(specified / best.misfit)),
                        specified * r.interval, best.misfit * r.interval);
  c.effect.choices["family"] = best.family->name;
  c.parameters = {{"order", static_cast<double>(best.order), static_cast<double>(best.order),
                   static_cast<double>(best.order)},
                  cutoff_parameter(r, best)};
  s.causes.push_back(std::move(c));
}

/// Recorded velocities that no filter of the positions yields: of another unit, sign, joint or zero.
///
/// The integral V of a velocity v follows the position x whatever filter computed v: x = x0 + V/g - (o/g) t +
/// d v with its factor g, its offset o and its delay d. Filters of unknown order change the size of fast
/// motion, so that only factors which no filter has are told.

namespace {

/// Factors that no low-pass of a usable velocity has (convention).
constexpr double least_factor = 0.8, most_factor = 1.25;

/// Least factor's difference from 1 that is told (convention), and what a low-pass of any order takes of a
/// motion of the angular frequency w that it delays by d: (w d)^2 / 2, six times as much for sharp ones.
constexpr double least_difference = 0.03, taken_by_filter = 3;

/// Share of the misfit that must vanish before a factor, an offset or a wrap explains it.
constexpr double explained_share = 0.9;

/// An offset of less is drowned in the noise of any velocity (convention). Of the velocity's rms.
constexpr double least_offset = 0.02;

/// A recorded velocity and the positions of its joint.
struct VelocityRecord {
  Eigen::ArrayXd time, position, velocity;

  Eigen::ArrayXd integral() const {
    Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(time.size());
    for (Eigen::Index k = 1; k < time.size(); ++k)
      sum[k] = sum[k - 1] + 0.5 * (velocity[k] + velocity[k - 1]) * (time[k] - time[k - 1]);
    return sum;
  }
};

struct Integrated {
  double factor = 1, offset = 0;       ///< of the velocity [1, SI]
  double delay = 0;                    ///< of the velocity behind the motion [s]
  double rms = 0, rms_as_written = 0;  ///< of the position that remains, with and without these two
};

double rms_of_fit(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y, Eigen::VectorXd& solution) {
  solution = least_norm_solution(columns, y);
  return (y - columns * solution).norm() / std::sqrt(static_cast<double>(y.size()));
}

Integrated integrated(const VelocityRecord& m) {
  const Eigen::Index n = m.time.size();
  Eigen::MatrixXd a(n, 4);
  a << m.velocity, Eigen::VectorXd::Ones(n), m.integral(), m.time - m.time.mean();
  Eigen::VectorXd x;
  Integrated fit;
  fit.rms_as_written = rms_of_fit(a.leftCols(2), m.position.matrix() - a.col(2), x);
  fit.rms = rms_of_fit(a, m.position, x);
  fit.factor = 1 / x[2];
  fit.offset = -x[3] * fit.factor;
  fit.delay = x[0];
  return fit;
}

/// Derivative of the position over nine rows.
Eigen::ArrayXd derivative(const VelocityRecord& m) {
  constexpr Eigen::Index half = 4;
  const Eigen::Index n = m.time.size();
  Eigen::ArrayXd v(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index from = std::max<Eigen::Index>(k - half, 0), to = std::min(k + half, n - 1);
    v[k] = (m.position[to] - m.position[from]) / (m.time[to] - m.time[from]);
  }
  return v;
}

/// The interval by which a velocity wraps; 0: it does not. Its values fill the interval and jump by it.
double wrap_of(const VelocityRecord& m) {
  const Eigen::ArrayXd error = m.velocity - derivative(m);
  const double half = m.velocity.abs().maxCoeff();
  std::vector<double> jumps;
  for (const double e : error)
    if (std::abs(e) > 1.5 * half) jumps.push_back(std::abs(e));
  if (jumps.size() < 3) return 0;
  const double interval = median(jumps);
  const auto near =
      std::count_if(jumps.begin(), jumps.end(), [&](double j) { return std::abs(j / interval - 1) < 0.1; });
  const bool fills = half > 0.45 * interval && half < 0.55 * interval;
  return fills && static_cast<double>(near) > explained_share * static_cast<double>(jumps.size()) ? interval
                                                                                                  : 0;
}

/// What a factor says of the velocity, and what to do.
struct FactorReading {
  std::string fault, what, remedy;
};

FactorReading reading_of(double factor, const LogColumn& column, bool prismatic) {
  if (std::abs(factor + 1) < 0.02)
    return {"sign", "has the opposite sign of the motion", "turn the sign of the column"};
  if (const auto unit = other_unit(column, factor, prismatic)) {
    const std::string name(unit->name);
    return {
        "unit",
        "looks like " + name + ": its values are " + significant(factor, 4) + " times those of the motion",
        "write [" + name + "] in the header, or convert the column"};
  }
  return {"factor", "is " + significant(factor, 4) + " times that of the motion",
          "look whether it is that of the motor, before its gear, or of another joint"};
}

}  // namespace

void check_velocity_column(Sanity& s, std::size_t joint) {
  const auto column = s.log.find(LogSignal::velocity, joint), stamps = s.log.find(LogSignal::time);
  if (!column || !stamps || s.log.values.rows() < 200) return;
  const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, joint);
  if (!measured) return;
  const bool decoded = std::any_of(s.causes.begin(), s.causes.end(), [&](const Cause& c) {
    return c.effect.type == decoding_effect().name && c.effect.joint == s.model.chain.independent[joint].name;
  });
  const VelocityRecord m{s.log.values.col(*stamps), *measured, s.log.values.col(*column)};
  const Eigen::Index n = m.time.size();
  const Eigen::ArrayXd steps = m.time.tail(n - 1) - m.time.head(n - 1);
  const double least_motion = 50 * std::sqrt(12.0) * ideal_sigma(s, joint);
  // Across a gap of the record nothing is integrated.
  if (decoded || peak_to_peak(m.position) < least_motion || steps.maxCoeff() > 5 * steps.mean()) return;
  const LogColumn head = s.log.columns[static_cast<std::size_t>(*column)];
  const Integrated fit = integrated(m);
  const auto found = [&](const std::string& fault, std::map<std::string, double> numbers,
                         const std::string& what, const std::string& remedy) {
    report_fault(s, joint, fault, std::move(numbers), fit.rms_as_written, fit.rms, what, remedy);
    drop_column(s.log, *column);
  };
  const std::string unit = s.model.chain.independent[joint].prismatic() ? "m/s" : "rad/s",
                    offset(offset_effect().name);
  if (peak_to_peak(m.velocity) == 0)
    return found("constant", {}, "is constant while the joint moves",
                 "look whether the drive sends it, or leave the column out");
  if (const double interval = wrap_of(m); interval > 0)
    return found("wrap", {{"interval", interval}},
                 "wraps at +-" + readable(interval / 2, unit) + ", and goes on with the opposite sign",
                 "record it with more bits, or in a coarser unit; lower the speed");
  const double moves = standard_deviation(m.position);
  const bool told = fit.rms < (1 - explained_share) * std::min(fit.rms_as_written, moves);
  const Eigen::ArrayXd bend = derivative({m.time, m.velocity, {}});
  const double by_filter = taken_by_filter * std::pow(fit.delay * rms(bend) / rms(m.velocity), 2);
  const bool usual = fit.factor > least_factor && fit.factor < most_factor &&
                     std::abs(fit.factor - 1) < least_difference + by_filter;
  if (told && !usual) {
    const FactorReading r = reading_of(fit.factor, head, s.model.chain.independent[joint].prismatic());
    found(r.fault, {{"factor", fit.factor}}, r.what, r.remedy);
  } else if (told && std::abs(fit.offset) > least_offset * rms(m.velocity)) {
    found(offset, {{offset, fit.offset}},
          "is not zero at rest: it has an offset of " + readable(fit.offset, unit),
          "subtract it: calibrate the zero of the sensor or the converter that measures it");
  } else if (fit.rms_as_written > 0.5 * moves) {
    found("unrelated", {}, "does not follow the motion of its joint",
          "look whether the column is that of another joint, or leave it out");
  }
}

}  // namespace qerr::sanity
