#include "bound/signal_errors.hpp"

#include <cmath>

#include "lanes/batch.hpp"
#include "qerr/bound/workspace.hpp"

namespace qerr {

namespace {

/// Derivative of the independent joints with respect to each error; 0 for origins.
Eigen::MatrixXd moved_by(const std::vector<IndependentError>& errors, const Transmission& t) {
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(t.encoders.size()),
                                                static_cast<Eigen::Index>(errors.size()));
  for (Eigen::Index e = 0; e < moved.cols(); ++e)
    if (const IndependentError& error = errors[static_cast<std::size_t>(e)];
        error.where != IndependentError::Where::origin)
      moved.col(e) = moved_joints(t, error);
  return moved;
}

template <class Get>
Eigen::VectorXd of_each(const std::vector<IndependentError>& errors, Get get) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(errors.size()));
  for (Eigen::Index e = 0; e < values.size(); ++e) values[e] = get(errors[static_cast<std::size_t>(e)]);
  return values;
}

}  // namespace

Eigen::MatrixXd signal_rows(const OperationalModel& model, const Eigen::VectorXd& q) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(model.signals.size()), q.size());
  for (Eigen::Index s = 0; s < rows.rows(); ++s) {
    const Signal& signal = model.signals[static_cast<std::size_t>(s)];
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
  white_ = of_each(errors, [&](const auto& e) {
    const bool white = e.sigma_ratios.empty() ||
                       (!requested.filters.empty() && e.sigma_ratios.front() == requested.filters.front().h2);
    return white ? e.sigma : 0;
  });
  slow_ = sigma - white_;
  const auto count = static_cast<Eigen::Index>(model.signals.size());
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
  const auto row = static_cast<Eigen::Index>(signal);
  const Eigen::VectorXd squares = column.cwiseAbs2();
  const double width = column.cwiseAbs().dot(half_width_), mean = std::abs(column.dot(mean_));
  const auto write = [&](std::size_t block, double value) { figures[(block + at) * batch_size] = value; };
  for (std::size_t f = 0; f < behind_.size(); ++f) {
    const Behind& b = behind_[f];
    const double worst = b.l1 * width + b.dc_gain * mean + b.peak[row];
    const double sigma = std::sqrt(squares.dot(b.variance) + b.along_motion[row]);
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
      write(layout_.in_motion + filter, std::sqrt(squares.dot(b.in_motion) + b.along_motion[row]));
  }
}

/// Half widths times ||G||_1, means times G(1); white errors times ||G||_2, and others, of which the spectrum
/// is not known, times ||G||_1, the most that any frequency passes.
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
  double variance = sum(n.h2.cwiseAbs2(), white_.cwiseAbs2()) + sum(n.l1.cwiseAbs2(), slow_.cwiseAbs2());
  if (model_.along_motion) {
    const SignalMoments& joints = model_.along_motion->joints;
    const SignalNorms by_joint =
        s.kind->norms(model_, s.index, q, Eigen::MatrixXd::Identity(q.size(), q.size()), loops);
    worst += sum(by_joint.l1, joints.peak);
    variance += std::pow(sum(by_joint.l1, joints.covariance.diagonal().cwiseSqrt()), 2);
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
  Eigen::MatrixXd all(moved_.rows(), static_cast<Eigen::Index>(batch_size));
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
        set(s, at, columns.row(static_cast<Eigen::Index>(s)).transpose(), figures + i);
  }
}

}  // namespace qerr
