#include "bound/error_columns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "bound/signal_errors.hpp"
#include "core/parallel.hpp"
#include "kinematics/sampler.hpp"

namespace qerr {

namespace {

/// Rotation of the frame before a joint of the chain, or before the tip, in the base frame.
Eigen::Matrix3d axes_before(const Chain& chain, const Eigen::VectorXd& q, std::size_t link) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  for (std::size_t k = 0; k < link; ++k) {
    const ChainJoint& joint = chain.joints[k];
    axes = axes * joint.origin.linear();
    if (joint.prismatic) continue;
    const double angle = joint.multiplier * q[joint.coordinate] + joint.offset;
    axes = axes * Eigen::AngleAxisd(angle, joint.axis);
  }
  return axes;
}

bool same_place(const IndependentError& a, const IndependentError& b) {
  if (a.where != b.where) return false;
  if (a.where != IndependentError::Where::origin) return a.owner == b.owner;
  return a.link == b.link && a.direction == b.direction;
}

bool needs_rotation(const OperationalModel& model) {
  return model.frame == CoordinateFrame::tip || std::ranges::any_of(model.coordinates, is_euler_angle);
}

Eigen::VectorXd zeros(std::size_t count) { return Eigen::VectorXd::Zero(count); }

/// @param noise  of the filter in a motion [quantization intervals]; null: not known
ErrorWeights::Filtered filtered_weights(const ErrorColumns& columns, const OperationalModel& model,
                                        std::size_t filter, const Norms& norms,
                                        const Eigen::VectorXd* noise) {
  ErrorWeights::Filtered w{norms.l1.upper,
                           std::abs(norms.dc_gain),
                           {},
                           {},
                           zeros(columns.columns()),
                           zeros(columns.coordinates()),
                           zeros(columns.coordinates())};
  if (model.along_motion) {
    w.added_worst = model.along_motion->filtered[filter].peak;
    w.added_variance = model.along_motion->filtered[filter].covariance.diagonal();
  }
  const std::vector<IndependentError> errors = independent_errors(model);
  const auto of_errors = [&](std::size_t count, bool beside_noise_in_motion) {
    Eigen::VectorXd variance = zeros(columns.columns());
    const Eigen::VectorXd ratios = sigma_ratios(errors, filter, norms.h2, beside_noise_in_motion);
    for (std::size_t i = 0; i < count; ++i)
      variance[columns.column_of(errors[i])] += std::pow(errors[i].sigma * ratios[i], 2);
    return variance;
  };
  w.variance_of_quantization = of_errors(model.transmission.encoders.size(), false);
  if (!sigma_is_known(model.sources, filter)) return w;
  w.variance = of_errors(errors.size(), false);
  if (!noise) return w;
  w.variance_in_motion = of_errors(errors.size(), true);
  w.variance_in_motion.head(noise->size()) +=
      noise->cwiseProduct(resolutions(model.transmission)).cwiseAbs2();
  return w;
}

}  // namespace

Eigen::VectorXd error_column(const IndependentError& s, const OperationalModel& model,
                             const Eigen::VectorXd& q, const Eigen::Matrix3d& rotation,
                             const Eigen::MatrixXd& joint_rows, const Eigen::MatrixXd& encoder_rows) {
  const auto i = static_cast<Eigen::Index>(s.owner);
  if (s.where == IndependentError::Where::joint) return joint_rows.col(i);
  if (s.where == IndependentError::Where::encoder) return encoder_rows.col(i);
  Eigen::Vector3d shift = axes_before(model.chain, q, s.link) * s.direction;
  if (model.frame == CoordinateFrame::tip) shift = rotation.transpose() * shift;
  Eigen::VectorXd column = Eigen::VectorXd::Zero(joint_rows.rows());
  for (std::size_t k = 0; k < model.coordinates.size(); ++k) {
    const Coordinate coordinate = model.coordinates[k];
    if (is_position(coordinate)) column[k] = shift[static_cast<Eigen::Index>(coordinate)];
  }
  return column;
}

ErrorColumns::ErrorColumns(const OperationalModel& model, const std::vector<IndependentError>& sources,
                           const Configurations& configurations, unsigned threads, InstructionSet set)
    : count_(size(configurations)),
      padded_((count_ + batch_size - 1) / batch_size * batch_size),
      coordinates_(model.coordinates.size() + model.signals.size()),
      joints_(model.chain.joints.size()),
      coupled_(!model.transmission.coupling.is_identity()) {
  const std::size_t encoders = model.transmission.encoders.size();
  for (std::size_t e = 0; e < encoders; ++e) places_.push_back({IndependentError::Where::encoder, e});
  for (IndependentError s : sources) {
    if (!coupled_ && s.where == IndependentError::Where::joint) continue;
    if (std::ranges::none_of(places_, [&](const auto& p) { return same_place(p, s); }))
      places_.push_back(std::move(s));
  }
  set_plain(model);
  values_ = AlignedNumbers(coordinates_ * columns() * padded_);
  norms_ = AlignedNumbers(joints_ * padded_);
  constexpr std::size_t batches_per_task = 16;
  const std::size_t batches = padded_ / batch_size;
  parallel_for((batches + batches_per_task - 1) / batches_per_task, threads, [&](std::size_t task) {
    Sampler sampler(configurations, set);
    BatchedJacobian jacobian(model.chain, set);
    AlignedNumbers q(encoders * batch_size), to(6 * joints_ * batch_size);
    const std::size_t end = std::min(batches, (task + 1) * batches_per_task);
    for (std::size_t b = task * batches_per_task; b < end; ++b) {
      sampler(b * batch_size, q.data());
      jacobian(q.data(), to.data());
      if (of_joints_.size() > 0)
        mix_batch(model, b * batch_size, to.data());
      else
        compute_batch(model, b * batch_size, q.data(), to.data());
    }
  });
}

/// Columns that are sums of columns of the joint Jacobian in the base frame.
void ErrorColumns::set_plain(const OperationalModel& model) {
  const bool at_origins = std::ranges::any_of(
      places_, [](const IndependentError& p) { return p.where == IndependentError::Where::origin; });
  if (needs_rotation(model) || at_origins || !model.signals.empty()) return;
  of_joints_.resize(joints_, columns());
  for (std::size_t k = 0; k < columns(); ++k) {
    const Eigen::VectorXd moved = moved_joints(model.transmission, places_[k]);
    for (std::size_t j = 0; j < joints_; ++j) {
      const ChainJoint& joint = model.chain.joints[j];
      of_joints_(j, k) = joint.multiplier * moved[joint.coordinate];
    }
  }
}

void ErrorColumns::mix_batch(const OperationalModel& model, std::size_t first, const double* jacobians) {
  const std::size_t count = std::min(batch_size, count_ - first);
  for (std::size_t c = 0; c < coordinates_; ++c)
    for (std::size_t k = 0; k < columns(); ++k)
      for (std::size_t j = 0; j < joints_; ++j) {
        const double weight = of_joints_(j, k);
        const double* const from =
            jacobians + (6 * j + static_cast<std::size_t>(model.coordinates[c])) * batch_size;
        double* const to = &values_[(c * columns() + k) * padded_ + first];
        for (std::size_t i = 0; i < count && weight != 0; ++i) to[i] += weight * from[i];
      }
  for (std::size_t j = 0; j < joints_; ++j)
    for (std::size_t i = 0; i < count; ++i) {
      const double* const x = jacobians + 6 * j * batch_size + i;
      norms_[j * padded_ + first + i] =
          std::sqrt(x[0] * x[0] + x[batch_size] * x[batch_size] + x[2 * batch_size] * x[2 * batch_size]);
    }
}

void ErrorColumns::compute_batch(const OperationalModel& model, std::size_t first, const double* q,
                                 const double* jacobians) {
  const bool rotated = needs_rotation(model);
  const std::size_t encoders = model.transmission.encoders.size();
  Jacobian joints(6, joints_);
  Eigen::VectorXd at(encoders);
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  for (std::size_t i = 0; i < std::min(batch_size, count_ - first); ++i) {
    for (std::size_t e = 0; e < 6 * joints_; ++e)
      joints.data()[e] = jacobians[e * batch_size + i];  // column-major
    for (std::size_t j = 0; j < encoders; ++j) at[j] = q[j * batch_size + i];
    if (rotated) rotation = forward_kinematics(model.chain, at).linear();
    Eigen::MatrixXd rows = coordinate_rows(model.coordinates, joints, rotation, model.frame);
    const Eigen::Array<bool, Eigen::Dynamic, 1> unbounded = !rows.array().isFinite().rowwise().all();
    for (Eigen::Index c = 0; c < rows.rows(); ++c)
      if (unbounded[c]) rows.row(c).setZero();
    Eigen::MatrixXd joint_rows(coordinates_, encoders);
    joint_rows << to_independent(model.chain, rows), signal_rows(model, at);
    const Eigen::MatrixXd encoder_rows = joint_rows * model.transmission.coupling;
    for (std::size_t k = 0; k < columns(); ++k) {
      const Eigen::VectorXd column = error_column(places_[k], model, at, rotation, joint_rows, encoder_rows);
      for (std::size_t c = 0; c < coordinates_; ++c) {
        const auto row = static_cast<Eigen::Index>(c);
        values_[(c * columns() + k) * padded_ + first + i] =
            k < encoders && row < unbounded.size() && unbounded[row] ? std::numeric_limits<double>::infinity()
                                                                     : column[row];
      }
    }
    for (std::size_t j = 0; j < joints_; ++j)
      norms_[j * padded_ + first + i] = joints.col(j).head<3>().norm();
  }
}

bool ErrorColumns::has_column(const IndependentError& s) const {
  return (!coupled_ && s.where == IndependentError::Where::joint) ||
         std::ranges::any_of(places_, [&](const auto& p) { return same_place(p, s); });
}

std::size_t ErrorColumns::column_of(const IndependentError& s) const {
  if (!coupled_ && s.where == IndependentError::Where::joint) return s.owner;
  const auto found = std::ranges::find_if(places_, [&](const auto& p) { return same_place(p, s); });
  if (found == places_.end()) throw std::logic_error("no column for this error source");
  return found - places_.begin();
}

ErrorWeights error_weights(const ErrorColumns& columns, const OperationalModel& model,
                           const std::vector<Norms>& filters,
                           const std::vector<Eigen::VectorXd>& noise_in_motion) {
  ErrorWeights w{zeros(columns.columns()),
                 zeros(columns.columns()),
                 zeros(columns.columns()),
                 zeros(columns.coordinates()),
                 zeros(columns.coordinates()),
                 linearization_remainder(model.chain, joint_error(model).worst_case),
                 {}};
  for (const IndependentError& e : independent_errors(model)) {
    const auto k = static_cast<Eigen::Index>(columns.column_of(e));
    w.half_width[k] += e.half_width;
    w.mean[k] += e.mean;
    w.variance[k] += e.sigma * e.sigma;
  }
  if (model.along_motion) {
    w.added_worst = model.along_motion->tip.peak;
    w.added_variance = model.along_motion->tip.covariance.diagonal();
  }
  for (std::size_t f = 0; f < filters.size(); ++f)
    w.filtered.push_back(filtered_weights(columns, model, f, filters[f],
                                          is_known(noise_in_motion, f) ? &noise_in_motion[f] : nullptr));
  return w;
}

}  // namespace qerr
