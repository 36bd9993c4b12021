#include "qerr/diagnose/evidence.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "qerr/core/parallel.hpp"
#include "qerr/core/random.hpp"
#include "smooth_path.hpp"

namespace qerr {

namespace {

constexpr std::uint64_t drawn_rows = 0x64726177;

/// The encoder's own coordinate by the references of all joints that it feels; empty where one is missing.
Eigen::ArrayXd reference_of(const OperationalModel& model, const Log& log, Eigen::Index encoder,
                            double& grid) {
  const Eigen::MatrixXd to_encoders = model.transmission.coupling.inverse();
  Eigen::ArrayXd x = Eigen::ArrayXd::Zero(log.values.rows());
  for (Eigen::Index j = 0; j < to_encoders.cols(); ++j) {
    if (std::abs(to_encoders(encoder, j)) < 1e-12) continue;
    const auto column = log.find(LogSignal::reference, static_cast<std::size_t>(j));
    if (!column) return {};
    x += to_encoders(encoder, j) * log.values.col(*column);
    grid = std::max(
        grid, std::abs(to_encoders(encoder, j)) * log.columns[static_cast<std::size_t>(*column)].step());
  }
  return x;
}

/// What an encoder reads by the positions that are logged for the joints that it feels; empty where one is
/// missing. A joint that has counts stands for the position that they make, if it feels no other encoder.
Eigen::ArrayXd measured_of(const OperationalModel& model, const Log& log, Eigen::Index encoder) {
  const Eigen::MatrixXd& coupling = model.transmission.coupling;
  const Eigen::MatrixXd to_encoders = coupling.inverse();
  Eigen::ArrayXd x = Eigen::ArrayXd::Zero(log.values.rows());
  for (Eigen::Index j = 0; j < to_encoders.cols(); ++j) {
    if (std::abs(to_encoders(encoder, j)) < 1e-12) continue;
    const auto joint = static_cast<std::size_t>(j);
    const auto measured = log.find(LogSignal::measured, joint), counts = log.find(LogSignal::counts, joint);
    const bool alone = (coupling.row(j).array().abs() > 1e-12).count() == 1;
    if (measured)
      x += to_encoders(encoder, j) * log.values.col(*measured).array();
    else if (counts && alone)
      x += to_encoders(encoder, j) * coupling(j, j) * model.transmission.encoders[joint].resolution *
           log.values.col(*counts).array();
    else
      return {};
  }
  return x;
}

/// Whether an encoder feels its own joint only.
bool alone(const OperationalModel& model, Eigen::Index encoder) {
  const Eigen::MatrixXd to_encoders = model.transmission.coupling.inverse();
  return (to_encoders.row(encoder).array().abs() > 1e-12).count() == 1;
}

/// Means of a column over groups of rows.
Eigen::ArrayXd means(const Eigen::ArrayXd& column, const std::vector<RowGroup>& groups) {
  if (column.size() == 0) return column;
  Eigen::ArrayXd out(static_cast<Eigen::Index>(groups.size()));
  for (std::size_t g = 0; g < groups.size(); ++g)
    out[static_cast<Eigen::Index>(g)] =
        column.segment(groups[g].first, groups[g].end - groups[g].first).mean();
  return out;
}

}  // namespace

std::vector<RowGroup> independent_rows(const Evidence& e, Eigen::Index most) {
  // The noise alone must not make two rows of one.
  const double apart = std::max(3 * e.path_noise, 0.05 * e.step());
  std::vector<RowGroup> all;
  Eigen::Index first = 0;
  for (Eigen::Index k = 1; k <= e.rows(); ++k)
    if (k == e.rows() || e.measured[k] != e.measured[first] || std::abs(e.path[k] - e.path[first]) > apart ||
        e.side[k] != e.side[first]) {
      all.push_back({first, k});
      first = k;
    }
  const auto count = static_cast<Eigen::Index>(all.size());
  if (count <= most) return all;
  // At random within each stretch: evenly spaced rows could keep pace with the motion.
  std::vector<RowGroup> drawn;
  for (Eigen::Index i = 0; i < most; ++i) {
    const Eigen::Index from = i * count / most, to = (i + 1) * count / most;
    const double u = unit_interval(random_bits(0, static_cast<std::uint64_t>(i), drawn_rows));
    drawn.push_back(
        all[static_cast<std::size_t>(from + static_cast<Eigen::Index>(u * static_cast<double>(to - from)))]);
  }
  return drawn;
}

Evidence independent(const Evidence& e, const std::vector<RowGroup>& groups) {
  Evidence few = e;
  for (Eigen::ArrayXd* column :
       {&few.time, &few.reference, &few.measured, &few.path, &few.velocity, &few.side, &few.joint_path,
        &few.joint_velocity, &few.effort, &few.temperature, &few.chance})
    *column = means(*column, groups);
  return few;
}

namespace {

/// @param time  from the first row [s]; empty: the rows are in no order
std::optional<Evidence> evidence_of(const OperationalModel& model, const Log& log, const Eigen::ArrayXd& time,
                                    std::size_t encoder) {
  const auto number = static_cast<Eigen::Index>(encoder);
  Evidence e;
  e.reference = reference_of(model, log, number, e.grid);
  if (e.reference.size() == 0) return std::nullopt;
  e.encoder = model.transmission.encoders[encoder];
  const auto counts = log.find(LogSignal::counts, encoder);
  e.counted = counts.has_value();
  e.measured = counts ? Eigen::ArrayXd(log.values.col(*counts) * e.encoder.resolution)
                      : measured_of(model, log, number);
  if (e.measured.size() == 0) return std::nullopt;
  e.joint = model.chain.independent[encoder].name;
  e.number = number;
  e.prismatic = model.chain.independent[encoder].prismatic();
  e.ordered = time.size() > 0;
  if (e.ordered) {
    e.time = time;
    SmoothPath smooth = smooth_path(time, e.reference, e.grid);
    e.path = std::move(smooth.position);
    e.velocity = std::move(smooth.velocity);
    e.noise = smooth.noise;
    e.path_noise = smooth.left;
    if (!alone(model, number)) {
      SmoothPath own = smooth_path(time, log.values.col(*log.find(LogSignal::reference, encoder)), e.grid);
      e.joint_path = std::move(own.position);
      e.joint_velocity = std::move(own.velocity);
    }
    e.side = side_of_motion(e.joint_angle(), std::max(10 * e.noise, 0.1 * e.step()));
  } else {
    const Eigen::Index rows = e.rows();
    e.time = Eigen::ArrayXd::LinSpaced(rows, 0, static_cast<double>(std::max<Eigen::Index>(rows - 1, 1)));
    e.path = e.reference;
    e.velocity = e.side = Eigen::ArrayXd::Zero(rows);
    e.noise = e.path_noise = e.grid / std::sqrt(12.0);
  }
  if (const auto effort = log.find(LogSignal::effort, encoder)) e.effort = log.values.col(*effort);
  if (const auto warm = log.find(LogSignal::temperature, encoder))
    e.temperature = log.values.col(*warm) - log.values(0, *warm);
  return e;
}

}  // namespace

std::vector<Evidence> evidence(const OperationalModel& model, const Log& log, unsigned threads) {
  Eigen::ArrayXd time;
  if (const auto stamps = log.find(LogSignal::time)) time = log.values.col(*stamps) - log.values(0, *stamps);
  std::vector<std::optional<Evidence>> found(model.chain.independent.size());
  parallel_for(found.size(), threads, [&](std::size_t i) { found[i] = evidence_of(model, log, time, i); });
  std::vector<Evidence> all;
  for (auto& e : found)
    if (e) all.push_back(std::move(*e));
  return all;
}

}  // namespace qerr
