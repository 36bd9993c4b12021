#include "diagnose/record/evidence.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "core/parallel.hpp"
#include "core/random.hpp"
#include "core/statistics.hpp"
#include "diagnose/record/smooth_path.hpp"

namespace qerr {

namespace {

constexpr double negligible_weight = 1e-12;  ///< by rounding errors
constexpr double median_of_normal = 0.6745;  ///< median absolute value of a standard normal variable

/// Change of the encoder's coordinate per unit of every joint.
Eigen::RowVectorXd joint_weights(const OperationalModel& model, Eigen::Index encoder) {
  return model.transmission.coupling.inverse().row(encoder);
}

}  // namespace

double resolution_of(const Log& log, Eigen::Index column) {
  const auto seen = log.values.col(column);
  return seen.size() > 0 && (seen != seen[0]).any() ? log.columns[static_cast<std::size_t>(column)].step()
                                                    : 0;
}

bool depends_on_one_joint(const OperationalModel& model, Eigen::Index encoder) {
  return (joint_weights(model, encoder).array().abs() > negligible_weight).count() == 1;
}

bool has_reference(const OperationalModel& model, const Log& log, Eigen::Index encoder) {
  const Eigen::RowVectorXd weights = joint_weights(model, encoder);
  for (Eigen::Index j = 0; j < weights.size(); ++j)
    if (!(std::abs(weights[j]) < negligible_weight) &&
        !log.find(LogSignal::reference, static_cast<std::size_t>(j)))
      return false;
  return log.values.rows() > 0;
}

EncoderReference encoder_reference(const OperationalModel& model, const Log& log, Eigen::Index encoder) {
  if (!has_reference(model, log, encoder)) return {};
  const Eigen::RowVectorXd weights = joint_weights(model, encoder);
  EncoderReference r;
  const auto stamps = log.find(LogSignal::time);
  for (Eigen::Index j = 0; j < weights.size(); ++j) {
    if (std::abs(weights[j]) < negligible_weight) continue;
    const auto column = log.find(LogSignal::reference, static_cast<std::size_t>(j));
    const LogColumn& head = log.columns[static_cast<std::size_t>(*column)];
    if (r.position.size() == 0)
      r.position = weights[j] * log.values.col(*column);
    else
      r.position += weights[j] * log.values.col(*column);
    r.log_resolution = std::max(r.log_resolution, std::abs(weights[j]) * resolution_of(log, *column));
    if (stamps && head.samples)
      r.noise = std::hypot(r.noise, weights[j] * noise_between(head, log.values.col(*stamps)));
  }
  return r;
}

Eigen::ArrayXd encoder_measured(const OperationalModel& model, const Log& log, Eigen::Index encoder) {
  const Eigen::RowVectorXd weights = joint_weights(model, encoder);
  Eigen::ArrayXd x = Eigen::ArrayXd::Zero(log.values.rows());
  for (Eigen::Index j = 0; j < weights.size(); ++j) {
    if (std::abs(weights[j]) < negligible_weight) continue;
    const auto joint = measured_joint(log, log.values, model.transmission, static_cast<std::size_t>(j));
    if (!joint) return {};
    x += weights[j] * *joint;
  }
  return x;
}

namespace {

/// Means of a column over groups of rows.
Eigen::ArrayXd means(const Eigen::ArrayXd& column, const std::vector<RowGroup>& groups) {
  if (column.size() == 0) return column;
  Eigen::ArrayXd out(static_cast<Eigen::Index>(groups.size()));
  for (std::size_t g = 0; g < groups.size(); ++g)
    out[static_cast<Eigen::Index>(g)] =
        column.segment(groups[g].first, groups[g].end - groups[g].first).mean();
  return out;
}

/// A row of the i-th of `most` equal sections of some rows. Evenly spaced rows could be commensurate with a
/// periodic motion.
Eigen::Index drawn_row(Eigen::Index rows, std::uint64_t seed, Eigen::Index i, Eigen::Index most) {
  const Eigen::Index from = i * rows / most, to = (i + 1) * rows / most;
  const double u = unit_interval(random_bits(seed, static_cast<std::uint64_t>(i), 0));
  return from + static_cast<Eigen::Index>(u * static_cast<double>(to - from));
}

}  // namespace

std::vector<Eigen::ArrayXd*> series_of(Evidence& e) {
  return {&e.time,      &e.reference,  &e.measured,       &e.path,   &e.velocity,    &e.acceleration,
          &e.direction, &e.joint_path, &e.joint_velocity, &e.effort, &e.temperature, &e.random_sigma};
}

double shared_rows(const Evidence& e) {
  if (!e.ordered || !(e.path_noise > 0) || !(e.noise > e.path_noise)) return 1;
  return std::pow(e.noise / e.path_noise, 2);
}

Eigen::ArrayXd path_without_noise(const Evidence& e) {
  constexpr double negligible = 0.05;  // counts
  if (!e.ordered || e.path_noise < negligible * e.step()) return e.path;
  return sectioned_path(e.time, e.reference, e.path, e.noise);
}

std::vector<RowGroup> independent_rows(const Evidence& e, std::uint64_t seed, Eigen::Index most) {
  // Noise alone must not separate rows.
  const double distinct = std::max(3 * e.path_noise, 0.05 * e.step());
  const bool sided = e.ordered && (e.direction != 0).any();
  const Eigen::ArrayXd path = path_without_noise(e);
  std::vector<RowGroup> all;
  Eigen::Index first = 0;
  for (Eigen::Index k = 1; k <= e.rows(); ++k)
    if (k == e.rows() || e.measured[k] != e.measured[first] || std::abs(path[k] - path[first]) > distinct ||
        e.direction[k] != e.direction[first]) {
      // While a motor crosses the play, the reading does not tell where the joint is.
      if (!sided || e.direction[first] != 0) all.push_back({first, k});
      first = k;
    }
  return drawn(all, seed, most);
}

std::vector<RowGroup> drawn(const std::vector<RowGroup>& all, std::uint64_t seed, Eigen::Index most) {
  const auto count = static_cast<Eigen::Index>(all.size());
  if (count <= most) return all;
  std::vector<RowGroup> some;
  for (Eigen::Index i = 0; i < most; ++i)
    some.push_back(all[static_cast<std::size_t>(drawn_row(count, seed, i, most))]);
  return some;
}

Evidence group_means(const Evidence& e, const std::vector<RowGroup>& groups) {
  Evidence grouped = e;
  for (Eigen::ArrayXd* series : series_of(grouped)) *series = means(*series, groups);
  return grouped;
}

bool is_static(const Eigen::ArrayXd& reference, double step) {
  const Eigen::Index n = reference.size() - 1;
  if (n < 8) return false;
  const Eigen::ArrayXd moves = reference.tail(n) - reference.head(n);
  const double range = reference.maxCoeff() - reference.minCoeff();
  if (moves.abs().mean() < std::max(0.03 * range, 3 * step)) return false;
  const double power = moves.square().sum();
  return (moves.head(n - 1) * moves.tail(n - 1)).sum() < 0.3 * power;
}

namespace {

/// Standard deviation of the readings about the path from row to row. Readings with noise of their own do not
/// tell when a play has been crossed, and rows that are chosen by them would be biased.
double scatter_of_readings(const Evidence& e) {
  constexpr Eigen::Index enough = 20000;  // a median absolute deviation to 0.8 %
  std::vector<double> changes;
  for (Eigen::Index k = 1; k < e.rows(); k += std::max<Eigen::Index>(1, e.rows() / enough))
    changes.push_back(std::abs((e.measured[k] - e.path[k]) - (e.measured[k - 1] - e.path[k - 1])));
  return median(std::move(changes)) / (median_of_normal * std::sqrt(2.0));
}

/// Where most rows repeat a pose, the path is the mean reference of each, and the rows of a pose tell the
/// reference's noise. The encoder rounds a pose once: with the references as recorded, its rows would be as
/// many samples of one rounding error.
void average_repeated_poses(Evidence& e) {
  // Squares about the mean of a pose have the expectation of half those from row to row, with a standard
  // deviation of 10 % for 100 rows; while the joint creeps on within a count they are twice as large.
  constexpr double white = 1.25;
  std::vector<double> changes;
  for (Eigen::Index k = 1; k < e.rows(); ++k)
    if (e.measured[k] == e.measured[k - 1]) changes.push_back(std::abs(e.reference[k] - e.reference[k - 1]));
  if (2 * static_cast<Eigen::Index>(changes.size()) < e.rows()) return;
  const double rounding = e.path_noise;
  e.path_noise = std::max(rounding, median(std::move(changes)) / median_of_normal);  // of a difference
  const std::vector<RowGroup> poses = independent_rows(e, 0, e.rows());
  e.path_noise = rounding;
  Eigen::ArrayXd path(e.rows());
  double about_mean = 0, from_row_to_row = 0, of_means = 0;
  for (const RowGroup& pose : poses) {
    const Eigen::Index n = pose.end - pose.first;
    const auto x = e.reference.segment(pose.first, n);
    path.segment(pose.first, n).setConstant(x.mean());
    about_mean += (x - x.mean()).square().sum();
    from_row_to_row += 0.5 * (x.tail(n - 1) - x.head(n - 1)).square().sum();
    of_means += 1 / static_cast<double>(n);
  }
  if (about_mean > white * from_row_to_row) return;
  const auto count = static_cast<double>(poses.size());
  e.noise = std::max(rounding, std::sqrt(about_mean / (static_cast<double>(e.rows()) - count)));
  e.path_noise = std::max(rounding, e.noise * std::sqrt(of_means / count));
  e.path = std::move(path);
  e.repeated = true;
}

/// @param time  since the first row [s]; empty: the rows are not ordered
std::optional<Evidence> evidence_of(const OperationalModel& model, const Log& log, const Eigen::ArrayXd& time,
                                    std::size_t encoder) {
  const auto number = static_cast<Eigen::Index>(encoder);
  Evidence e;
  EncoderReference reference = encoder_reference(model, log, number);
  if (reference.position.size() == 0) return std::nullopt;
  e.reference = std::move(reference.position);
  e.log_resolution = reference.log_resolution;
  e.encoder = model.transmission.encoders[encoder];
  const auto counts = log.find(LogSignal::counts, encoder);
  e.counted = counts.has_value();
  e.measured = counts ? Eigen::ArrayXd(log.values.col(*counts) * e.encoder.resolution)
                      : encoder_measured(model, log, number);
  if (e.measured.size() == 0) return std::nullopt;
  e.joint = model.chain.independent[encoder].name;
  e.number = number;
  e.prismatic = model.chain.independent[encoder].prismatic();
  // The differences of a reference's noise have nothing in common either: of poses, readings jump as well.
  e.ordered = time.size() > 0 &&
              !(is_static(e.reference, e.encoder.resolution) && is_static(e.measured, e.encoder.resolution));
  if (e.ordered) {
    e.time = time;
    e.interval = time[time.size() - 1] / static_cast<double>(time.size());
    const double least_noise = std::max(e.log_resolution, std::sqrt(12.0) * reference.noise);
    SmoothPath smooth = smooth_path(time, e.reference, least_noise);
    e.path = std::move(smooth.position);
    e.velocity = std::move(smooth.velocity);
    e.acceleration = std::move(smooth.acceleration);
    e.noise = smooth.noise;
    e.path_noise = smooth.residual_noise;
    if (!depends_on_one_joint(model, number)) {
      SmoothPath own =
          smooth_path(time, log.values.col(*log.find(LogSignal::reference, encoder)), e.log_resolution);
      e.joint_path = std::move(own.position);
      e.joint_velocity = std::move(own.velocity);
      e.acceleration = std::move(own.acceleration);
    }
    e.direction = direction_of_motion(e.joint_angle(), std::max(10 * e.noise, 0.1 * e.step()));
    if (!e.coupled() && scatter_of_readings(e) < 0.7 * e.step())
      e.direction = direction_with_readings(e.path, e.measured, std::move(e.direction),
                                            std::max(8 * e.path_noise, 0.25 * e.step()), e.step());
  } else {
    const Eigen::Index rows = e.reference.size();
    e.time = Eigen::ArrayXd::LinSpaced(rows, 0, static_cast<double>(std::max<Eigen::Index>(rows - 1, 1)));
    e.path = e.reference;
    e.velocity = e.direction = Eigen::ArrayXd::Zero(rows);
    e.noise = e.path_noise = e.log_resolution / std::sqrt(12.0);
    average_repeated_poses(e);
  }
  if (const auto effort = log.find(LogSignal::effort, encoder)) {
    e.effort = log.values.col(*effort);
    e.driven = !log.columns[static_cast<std::size_t>(*effort)].computed;
    // Of what a drive needs beside its load the rotor's part is known well enough by the change of the speed.
    if (e.ordered && e.acceleration.size() == 0)
      e.acceleration = smooth_path(time, e.joint_rate(), 0, true).velocity;
  }
  if (const auto warm = log.find(LogSignal::temperature, encoder))
    e.temperature = log.values.col(*warm) - log.values(0, *warm);
  return e;
}

}  // namespace

std::vector<Evidence> evidence(const OperationalModel& model, const Log& log,
                               const std::vector<std::size_t>& encoders, unsigned threads) {
  Eigen::ArrayXd time;
  if (const auto stamps = log.find(LogSignal::time)) time = log.values.col(*stamps) - log.values(0, *stamps);
  std::vector<std::optional<Evidence>> found(encoders.size());
  parallel_for(found.size(), threads,
               [&](std::size_t i) { found[i] = evidence_of(model, log, time, encoders[i]); });
  std::vector<Evidence> all;
  for (auto& e : found)
    if (e) all.push_back(std::move(*e));
  return all;
}

std::vector<std::size_t> all_encoders(const OperationalModel& model) {
  std::vector<std::size_t> all(model.transmission.encoders.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

Evidence thinned(Evidence e, std::uint64_t seed) {
  constexpr Eigen::Index most = 1 << 16;
  if (e.rows() <= most) return e;
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < most; ++i) rows.push_back(drawn_row(e.rows(), seed, i, most));
  for (Eigen::ArrayXd* column : series_of(e))
    if (column->size() > 0) *column = (*column)(rows).eval();
  return e;
}

}  // namespace qerr
