#include "bound/signal_errors.hpp"

#include <algorithm>
#include <cmath>

#include "bound/signals/signals.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/bound/workspace.hpp"

namespace qerr {

namespace {

/// Derivative of the independent joints with respect to each error; 0 for origins.
Eigen::MatrixXd moved_by(const std::vector<IndependentError>& errors, const Transmission& t) {
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(std::ssize(t.encoders), std::ssize(errors));
  for (Eigen::Index e = 0; e < moved.cols(); ++e)
    if (const IndependentError& error = errors[e]; error.where != IndependentError::Where::origin)
      moved.col(e) = moved_joints(t, error);
  return moved;
}

template <class Get>
Eigen::VectorXd of_each(const std::vector<IndependentError>& errors, Get get) {
  Eigen::VectorXd values(std::ssize(errors));
  for (Eigen::Index e = 0; e < values.size(); ++e) values[e] = get(errors[e]);
  return values;
}

std::size_t index_of(const std::vector<Coordinate>& list, Coordinate c) {
  return std::ranges::find(list, c) - list.begin();
}

double length_at(const Eigen::VectorXd& values, const std::array<std::size_t, 3>& components) {
  double sum = 0;
  for (const std::size_t c : components) sum += std::pow(values[c], 2);
  return std::sqrt(sum);
}

}  // namespace

Eigen::MatrixXd signal_rows(const OperationalModel& model, const Eigen::VectorXd& q) {
  Eigen::MatrixXd rows(std::ssize(model.signals), q.size());
  for (Eigen::Index s = 0; s < rows.rows(); ++s) {
    const Signal& signal = model.signals[s];
    rows.row(s) = signal.kind->row(model, signal.index, q);
  }
  return rows;
}

SignalErrors::SignalErrors(const OperationalModel& model, const ErrorFigures& requested,
                           const FigureLayout& layout)
    : model_(model),
      layout_(layout),
      loops_(model.control, model.chain),
      rigorous_(requested.rigorous),
      own_worst_(layout.filtered_sigma > layout.filtered_worst),
      own_sigma_(layout.in_motion > layout.filtered_sigma) {
  const std::vector<IndependentError> errors = independent_errors(model);
  moved_ = moved_by(errors, model.transmission);
  half_width_ = of_each(errors, [](const auto& e) { return e.half_width; });
  mean_ = of_each(errors, [](const auto& e) { return e.mean; });
  const Eigen::VectorXd sigma = of_each(errors, [](const auto& e) { return e.sigma; });
  joints_ = joint_error(model).worst_case;
  white_ = of_each(errors, [](const auto& e) { return e.loop_ratios.empty() ? e.sigma : 0; });
  slow_ = sigma - white_;
  for (const IndependentError& e : errors) slow_ratios_.push_back(e.loop_ratios);
  const auto count = std::ssize(model.signals);
  for (std::size_t f = 0; f <= requested.filters.size(); ++f) {
    Behind& b = behind_.emplace_back();
    b.peak = b.along_motion = Eigen::VectorXd::Zero(count);
    if (model.along_motion) {
      const SignalMoments& m = f == 0 ? model.along_motion->tip : model.along_motion->filtered[f - 1];
      b.peak = m.peak.tail(count);
      b.along_motion = m.covariance.diagonal().tail(count);
    }
    b.variance = sigma.cwiseAbs2();
    if (f == 0) continue;
    const Norms& norms = requested.filters[f - 1];
    b.l1 = norms.l1.upper;
    b.dc_gain = std::abs(norms.dc_gain);
    b.variance = sigma.cwiseProduct(sigma_ratios(errors, f - 1, norms.h2)).cwiseAbs2();
    if (!is_known(requested.noise_in_motion, f - 1)) continue;
    b.in_motion = sigma.cwiseProduct(sigma_ratios(errors, f - 1, norms.h2, true)).cwiseAbs2();
    const Eigen::VectorXd& noise = requested.noise_in_motion[f - 1];
    b.in_motion.head(noise.size()) += noise.cwiseProduct(resolutions(model.transmission)).cwiseAbs2();
  }
}

double SignalErrors::remainder(std::size_t signal, const Eigen::VectorXd& q) const {
  const Signal& s = model_.signals[signal];
  return s.kind->remainder(model_, s.index, q, joints_);
}

/// @param column  derivative of the signal by each error
/// @param figures  of the configuration
void SignalErrors::set(std::size_t signal, const Eigen::VectorXd& q, const Eigen::VectorXd& column,
                       double* figures) const {
  const std::size_t at = model_.coordinates.size() + model_.lengths.size() + signal;
  const Eigen::VectorXd squares = column.cwiseAbs2();
  const double width = column.cwiseAbs().dot(half_width_), mean = std::abs(column.dot(mean_));
  const auto write = [&](std::size_t block, double value) { figures[(block + at) * batch_size] = value; };
  for (std::size_t f = 0; f < behind_.size(); ++f) {
    const Behind& b = behind_[f];
    const double worst = b.l1 * width + b.dc_gain * mean + b.peak[signal];
    const double sigma = std::sqrt(squares.dot(b.variance) + b.along_motion[signal]);
    if (f == 0) {
      write(layout_.worst_case, worst);
      write(layout_.sigma, sigma);
      if (rigorous_) write(layout_.rigorous, worst + remainder(signal, q));
      continue;
    }
    const std::size_t filter = (f - 1) * layout_.coordinates;
    if (own_worst_) write(layout_.filtered_worst + filter, worst);
    if (own_sigma_) write(layout_.filtered_sigma + filter, sigma);
    if (b.in_motion.size() > 0)
      write(layout_.in_motion + filter, std::sqrt(squares.dot(b.in_motion) + b.along_motion[signal]));
  }
}

/// Half widths times ||G||_1, means times G(1); white errors times ||G||_2, slow ones times their ratios
/// where these are known, and others times ||G||_1, the most that any frequency passes.
void SignalErrors::set_closed(std::size_t signal, const Eigen::VectorXd& q, const LoopsAt& loops,
                              double* figures) const {
  const Signal& s = model_.signals[signal];
  const SignalNorms n = s.kind->norms(model_, s.index, q, moved_, loops);
  const auto sum = [](const Eigen::RowVectorXd& norm, const Eigen::VectorXd& size) {
    double total = 0;
    for (Eigen::Index e = 0; e < size.size(); ++e)
      if (size[e] != 0) total += norm[e] * size[e];  // not inf * 0
    return total;
  };
  double worst = sum(n.l1, half_width_) + std::abs(sum(n.dc, mean_));
  double variance = sum(n.h2.cwiseAbs2(), white_.cwiseAbs2());
  for (Eigen::Index e = 0; e < slow_.size(); ++e) {
    if (slow_[e] == 0) continue;
    LoopsAt passed = loops;
    passed.slow = &slow_ratios_[e];
    variance += std::pow(s.kind->norms(model_, s.index, q, moved_.col(e), passed).l1[0] * slow_[e], 2);
  }
  if (model_.along_motion) {
    const SignalMoments& joints = model_.along_motion->joints;
    const Eigen::MatrixXd each = Eigen::MatrixXd::Identity(q.size(), q.size());
    LoopsAt passed = loops;
    passed.slow = &model_.along_motion->in_loops;
    worst += sum(s.kind->norms(model_, s.index, q, each, loops).l1, joints.peak);
    variance += std::pow(
        sum(s.kind->norms(model_, s.index, q, each, passed).l1, joints.covariance.diagonal().cwiseSqrt()), 2);
  }
  const std::size_t at = model_.coordinates.size() + model_.lengths.size() + signal;
  const auto write = [&](std::size_t block, double value) { figures[(block + at) * batch_size] = value; };
  write(layout_.worst_case, worst);
  write(layout_.sigma, std::sqrt(variance));
  if (rigorous_) write(layout_.rigorous, worst + remainder(signal, q));
  for (std::size_t f = 1; f < behind_.size(); ++f) {  // no filter passes it
    const std::size_t filter = (f - 1) * layout_.coordinates;
    if (own_worst_) write(layout_.filtered_worst + filter, 0);
    if (own_sigma_) write(layout_.filtered_sigma + filter, 0);
    if (behind_[f].in_motion.size() > 0) write(layout_.in_motion + filter, 0);
  }
}

void SignalErrors::operator()(const double* q, double* figures) {
  Eigen::MatrixXd all(moved_.rows(), batch_size);
  for (Eigen::Index i = 0; i < all.cols(); ++i)
    for (Eigen::Index j = 0; j < all.rows(); ++j) all(j, i) = q[j * all.cols() + i];
  loops_.move_to(all);
  for (std::size_t i = 0; i < batch_size; ++i) {
    const LoopsAt loops{&loops_, static_cast<Eigen::Index>(i)};
    const Eigen::VectorXd at = all.col(loops.configuration);
    const Eigen::MatrixXd columns = signal_rows(model_, at) * moved_;
    for (std::size_t s = 0; s < model_.signals.size(); ++s)
      if (is_closed(model_.signals[s]))
        set_closed(s, at, loops, figures + i);
      else
        set(s, at, columns.row(s).transpose(), figures + i);
  }
}

double largest_corner(const Eigen::Vector3d& mean, const Eigen::Matrix3Xd& generators) {
  const BoundKernels& kernels = select_kernels<BoundKernels>(instruction_set());
  const auto count = static_cast<std::size_t>(generators.cols());
  AlignedNumbers vectors(3 * (count + 1) * batch_size), lengths(batch_size), scratch(count * kernels.lanes);
  for (std::size_t lane = 0; lane < kernels.lanes; ++lane)
    for (Eigen::Index row = 0; row < 3; ++row) {
      const std::size_t at = static_cast<std::size_t>(row) * batch_size + lane;
      vectors[at] = mean[row];
      for (Eigen::Index g = 0; g < generators.cols(); ++g)
        vectors[3 * (static_cast<std::size_t>(g) + 1) * batch_size + at] = generators(row, g);
    }
  kernels.largest_corners(count, vectors.data(), vectors.data() + 3 * batch_size, kernels.lanes,
                          lengths.data(), scratch.data());
  return lengths[0];
}

LengthErrors::LengthErrors(const OperationalModel& model, const ErrorFigures& requested,
                           const FigureLayout& layout, InstructionSet set)
    : layout_(layout),
      filters_(requested.filters),
      rigorous_(requested.rigorous),
      own_worst_(layout.filtered_sigma > layout.filtered_worst),
      own_sigma_(layout.in_motion > layout.filtered_sigma),
      kernels_(select_kernels<BoundKernels>(set)),
      jacobian_(model.chain, set),
      columns_(6 * model.chain.joints.size() * batch_size),
      joints_(model.chain.joints.size()),
      components_(model.coordinates.size()) {
  const LinearizationRemainder r = linearization_remainder(model.chain, joint_error(model).worst_case);
  rotation_remainder_ = r.rotation;
  rotation_angle_ = r.rotation_angle;
  for (std::size_t f = 0; f < filters_.size(); ++f)
    in_motion_.push_back(f < requested.noise_in_motion.size() && requested.noise_in_motion[f].size() > 0);
  double shift = 0;  // of origins
  for (const IndependentError& e : independent_errors(model))
    if (e.where == IndependentError::Where::origin)
      shift += std::abs(e.mean) + e.half_width;
    else
      add_generator(model, e);
  for (const Coordinate c : model.lengths) {
    const Coordinate first = first_component(c);
    Length length{static_cast<std::size_t>(first), {}};
    for (std::size_t k = 0; k < 3; ++k)
      length.components[k] =
          index_of(model.coordinates, static_cast<Coordinate>(static_cast<std::size_t>(first) + k));
    const double of_origins = c == Coordinate::xyz ? shift : 0;
    length.added = of_origins;
    for (const Norms& norms : filters_) length.added_behind.push_back(norms.l1.upper * of_origins);
    if (model.along_motion) {
      length.added += length_at(model.along_motion->tip.peak, length.components);
      for (std::size_t f = 0; f < filters_.size(); ++f)
        length.added_behind[f] += length_at(model.along_motion->filtered[f].peak, length.components);
    }
    lengths_.push_back(length);
  }
  const std::size_t count = generators_.size();
  mean_ = AlignedNumbers(3 * batch_size);
  scaled_mean_ = AlignedNumbers(3 * batch_size);
  corners_ = AlignedNumbers(3 * count * batch_size);
  largest_ = AlignedNumbers(batch_size);
  scratch_ = AlignedNumbers(count * kernels_.lanes);
}

/// Errors along the same direction of the joints have one corner: their half widths add.
void LengthErrors::add_generator(const OperationalModel& model, const IndependentError& error) {
  const Eigen::VectorXd of_independent = moved_joints(model.transmission, error);
  biased_ = biased_ || error.mean != 0;
  Eigen::VectorXd of_joints(joints_);
  for (std::size_t k = 0; k < joints_; ++k) {
    const ChainJoint& joint = model.chain.joints[k];
    of_joints[k] = joint.multiplier * of_independent[joint.coordinate];
  }
  for (Generator& g : generators_)
    if (g.of_joints == of_joints) {
      g.half_width += error.half_width;
      g.mean += error.mean;
      return;
    }
  generators_.push_back({std::move(of_joints), error.half_width, error.mean});
}

void LengthErrors::set_vectors(const Length& length) {
  for (std::size_t c = 0; c < mean_.size(); ++c) mean_[c] = 0;
  for (std::size_t g = 0; g < generators_.size(); ++g)
    for (std::size_t row = 0; row < 3; ++row) {
      double* const corner = &corners_[(3 * g + row) * batch_size];
      std::fill_n(corner, batch_size, 0.0);
      for (std::size_t k = 0; k < joints_; ++k) {
        const double weight = generators_[g].of_joints[k];
        if (weight == 0) continue;
        const double* const column = &columns_[(6 * k + length.first + row) * batch_size];
        for (std::size_t c = 0; c < batch_size; ++c) corner[c] += column[c] * weight;
      }
      for (std::size_t c = 0; c < batch_size; ++c) {
        mean_[row * batch_size + c] += generators_[g].mean * corner[c];
        corner[c] *= generators_[g].half_width;
      }
    }
}

const double* LengthErrors::largest_corners(double of_mean) {
  for (std::size_t c = 0; c < mean_.size(); ++c) scaled_mean_[c] = of_mean * mean_[c];
  kernels_.largest_corners(generators_.size(), scaled_mean_.data(), corners_.data(), batch_size,
                           largest_.data(), scratch_.data());
  return largest_.data();
}

void LengthErrors::set_worst(const Length& length, std::size_t index, double* figures) {
  const auto row = [&](std::size_t first, std::size_t coordinate) {
    return figures + (first + coordinate) * batch_size;
  };
  set_vectors(length);
  const double* const linear = largest_corners(1);
  double* const worst = row(layout_.worst_case, index);
  for (std::size_t i = 0; i < batch_size; ++i) worst[i] = linear[i] + length.added;
  if (rigorous_) {
    // The remainder of a position is that of its components: it bounds a length.
    double* const rigorous = row(layout_.rigorous, index);
    const double *const x = row(layout_.worst_case, length.components[0]), *const rigorous_x =
                                                                               row(layout_.rigorous,
                                                                                   length.components[0]);
    for (std::size_t i = 0; i < batch_size; ++i)
      rigorous[i] = length.first == 0
                        ? worst[i] + (rigorous_x[i] - x[i])
                        : std::min(linear[i] + rotation_remainder_, rotation_angle_) + length.added;
  }
  for (std::size_t f = 0; f < filters_.size() && own_worst_; ++f) {
    const Norms& norms = filters_[f];
    const double l1 = norms.l1.upper;
    const double* const behind = biased_ && l1 > 0 ? largest_corners(norms.dc_gain / l1) : linear;
    double* const to = row(layout_.filtered_worst + f * layout_.coordinates, index);
    for (std::size_t i = 0; i < batch_size; ++i) to[i] = l1 * behind[i] + length.added_behind[f];
  }
}

/// @param block  of figures: index of the first coordinate's
double LengthErrors::root_of_sum(const Length& length, std::size_t block, const double* figures) const {
  double sum = 0;
  for (const std::size_t c : length.components) sum += std::pow(figures[(block + c) * batch_size], 2);
  return std::sqrt(sum);
}

void LengthErrors::set_sigmas(const Length& length, std::size_t index, std::size_t i, double* figures) const {
  const auto set = [&](std::size_t block) {
    figures[(block + index) * batch_size + i] = root_of_sum(length, block, figures + i);
  };
  set(layout_.sigma);
  for (std::size_t f = 0; f < filters_.size(); ++f) {
    if (own_sigma_) set(layout_.filtered_sigma + f * layout_.coordinates);
    if (in_motion_[f]) set(layout_.in_motion + f * layout_.coordinates);
  }
}

void LengthErrors::operator()(const double* q, double* figures) {
  jacobian_(q, columns_.data());
  for (std::size_t l = 0; l < lengths_.size(); ++l) {
    for (std::size_t i = 0; i < batch_size; ++i) set_sigmas(lengths_[l], components_ + l, i, figures);
    set_worst(lengths_[l], components_ + l, figures);
  }
}

}  // namespace qerr
