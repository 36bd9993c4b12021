#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/solve.hpp"
#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"
#include "effect/effects/effects.hpp"

/// Recorded velocities that no filter of the positions yields: of another unit, sign, joint or zero.
///
/// The integral V of a velocity v follows the position x whatever filter computed v: x = x0 + V/g - (o/g) t +
/// d v with its factor g, its offset o and its delay d. Filters of unknown order change the size of fast
/// motion, so that only factors which no filter has are told.
namespace qerr::sanity {

namespace {

/// Factors that no low-pass of a usable velocity has (convention).
constexpr double least_factor = 0.8, most_factor = 1.25;

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
std::pair<std::string, std::string> reading_of(double factor, const LogColumn& column, bool prismatic) {
  if (std::abs(factor + 1) < 0.02)
    return {"has the opposite sign of the motion", "turn the sign of the column"};
  if (const auto unit = other_unit(column, factor, prismatic)) {
    const std::string name(unit->name);
    return {
        "looks like " + name + ": its values are " + significant(factor, 4) + " times those of the motion",
        "write [" + name + "] in the header, or convert the column"};
  }
  return {"is " + significant(factor, 4) + " times that of the motion",
          "look whether it is that of the motor, before its gear, or of another joint"};
}

}  // namespace

void check_velocity_column(Sanity& s, std::size_t joint) {
  const auto column = s.log.find(LogSignal::velocity, joint), stamps = s.log.find(LogSignal::time);
  const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, joint);
  if (!column || !stamps || !measured || s.log.values.rows() < 200) return;
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
  const auto found = [&](const std::string& what, const std::string& remedy) {
    s.data.push_back({head.header + ' ' + what,
                      s.model.chain.independent[joint].name,
                      1,
                      {},
                      remedy,
                      DataKind::contradictory});
    drop_column(s.log, *column);
  };
  const std::string unit = s.model.chain.independent[joint].prismatic() ? "m/s" : "rad/s";
  if (peak_to_peak(m.velocity) == 0)
    return found("is constant while the joint moves",
                 "look whether the drive sends it, or leave the column out");
  if (const double interval = wrap_of(m); interval > 0)
    return found("wraps at +-" + readable(interval / 2, unit) + ", and goes on with the opposite sign",
                 "record it with more bits, or in a coarser unit; lower the speed");
  const Integrated fit = integrated(m);
  const double moves = standard_deviation(m.position);
  const bool told = fit.rms < (1 - explained_share) * std::min(fit.rms_as_written, moves);
  if (told && (fit.factor < least_factor || fit.factor > most_factor)) {
    const auto [what, remedy] = reading_of(fit.factor, head, s.model.chain.independent[joint].prismatic());
    found(what, remedy);
  } else if (told && std::abs(fit.offset) > least_offset * rms(m.velocity)) {
    found("is not zero at rest: it has an offset of " + readable(fit.offset, unit),
          "subtract it: calibrate the zero of the sensor or the converter that measures it");
  } else if (fit.rms_as_written > 0.5 * moves) {
    found("does not follow the motion of its joint",
          "look whether the column is that of another joint, or leave it out");
  }
}

}  // namespace qerr::sanity
