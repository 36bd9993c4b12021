#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>

#include "bound/signal_errors.hpp"
#include "filter/run/cascade.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "simulate/along_motion.hpp"
#include "simulate/motion_path.hpp"
#include "simulate/run.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr {

namespace {

/// Sums over samples, about the first one to avoid cancellation.
class MomentSums {
 public:
  void add(const Eigen::Ref<const Eigen::VectorXd>& sample) {
    if (count_ == 0) {
      shift_ = peak_ = sample;
      peak_.setZero();
      sum_.setZero(sample.size());
      squares_.setZero(sample.size(), sample.size());
    }
    deviation_ = sample - shift_;
    sum_ += deviation_;
    squares_.noalias() += deviation_ * deviation_.transpose();
    peak_ = peak_.cwiseMax(sample.cwiseAbs());
    count_ += 1;
  }

  SignalMoments moments() const {
    const Eigen::VectorXd mean = sum_ / count_;
    return {shift_ + mean, peak_, squares_ / count_ - mean * mean.transpose()};
  }

 private:
  double count_ = 0;
  Eigen::VectorXd shift_, sum_, peak_, deviation_;
  Eigen::MatrixXd squares_;
};

/// Moments of the errors of the model's coordinates and of its signals of other kinds, c(q) times the
/// joints', behind a filter; null: of the errors themselves, and of the joints'.
SignalMoments moments_of_tip(const OperationalModel& model, const std::vector<Effect>& effects,
                             const UnroundedRecord& record, const Filter* filter, SignalMoments* of_joints) {
  const auto m = std::ssize(model.coordinates);
  const auto n = std::ssize(model.transmission.encoders);
  constexpr std::size_t lanes = 8;
  const std::size_t signals = model.coordinates.size() + model.signals.size();
  const std::size_t width = (signals + lanes - 1) / lanes * lanes;
  PathErrors errors(model, as_built(model.chain, effects), Eigen::VectorXd::Zero(m));
  AlignedNumbers rows(width * batch_size), filtered(width * batch_size);
  std::unique_ptr<RowFilter> run;
  if (filter) run = std::make_unique<RowFilter>(*filter, width, batch_size);
  MomentSums tip, joints;
  Eigen::VectorXd joint(n), q(n);
  const auto joints_at = [&](const SensedBatch& batch, std::size_t sample) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const std::size_t at = static_cast<std::size_t>(j) * batch_size + sample;
      q[j] = batch.joint[at];
      joint[j] = batch.estimate[at] - batch.joint[at];
    }
  };
  bool first = true;
  record.read(model, effects, [&](const SensedBatch& batch, const std::vector<std::size_t>& used) {
    errors(batch);
    for (std::size_t k = 0; k < used.size(); ++k) {
      std::copy_n(errors.rows() + used[k] * errors.width(), m, rows.data() + k * width);
      if (model.signals.empty()) continue;
      joints_at(batch, used[k]);
      Eigen::Map<Eigen::VectorXd>(rows.data() + k * width + m, static_cast<Eigen::Index>(signals) - m) =
          signal_rows(model, q) * joint;
    }
    if (run && first) run->settle(rows.data());
    if (run) (*run)(rows.data(), width, used.size(), filtered.data());
    first = false;
    const double* const out = run ? filtered.data() : rows.data();
    for (std::size_t k = 0; k < used.size(); ++k) {
      if (!record.is_after_settling(batch.first + used[k])) continue;
      tip.add(Eigen::Map<const Eigen::VectorXd>(out + k * width, signals));
      if (!of_joints) continue;
      joints_at(batch, used[k]);
      joints.add(joint);
    }
  });
  if (of_joints) *of_joints = joints.moments();
  return tip.moments();
}

constexpr double most_usage_samples = 1e5, most_efforts = 1e4;

/// Evenly spaced instants of the motion: its samples if there are at most `most` of them.
std::vector<double> instants(const Motion& motion, double most) {
  const double samples = std::max(1.0, std::floor(motion.duration * motion.sample_rate + 0.5));
  const double count = std::min(samples, most);
  std::vector<double> times;
  for (double k = 0; k < count; ++k) times.push_back(k * samples / count / motion.sample_rate);
  return times;
}

using Rows = std::vector<std::vector<double>>;

void append(Rows& rows, const Eigen::VectorXd& values) {
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].push_back(values[i]);
}

void widen(Spread& s, double by) {
  s.lower -= by;
  s.upper += by;
}

/// Widens the ranges by a bound on peaks between the instants: for the position, step/4 times the largest
/// change of velocity per step; for the velocity, half of its largest second difference.
void widen_between_samples(Usage& u, const std::vector<double>& velocity, double step) {
  double change = 0, curvature = 0;
  for (std::size_t k = 1; k < velocity.size(); ++k) {
    change = std::max(change, std::abs(velocity[k] - velocity[k - 1]));
    if (k > 1) curvature = std::max(curvature, std::abs(velocity[k] - 2 * velocity[k - 1] + velocity[k - 2]));
  }
  widen(*u.position, 0.25 * change * step);
  widen(*u.velocity, 0.5 * curvature);
}

/// Position and velocity of every coordinate at the instants.
struct Path {
  Rows position, velocity;
  explicit Path(std::size_t count) : position(count), velocity(count) {}
};

/// The range of all values, and the means of those after the settling.
Spread spread_in(const Motion& motion, const std::vector<double>& values) {
  const double settling = motion.settling.value_or(0) / motion.duration;
  const auto first = static_cast<std::size_t>(settling * static_cast<double>(values.size()));
  Spread all = spread_of(values);
  const Spread counted = spread_of(std::span(values).subspan(std::min(first, values.size() - 1)));
  all.mean = counted.mean;
  all.mean_square = counted.mean_square;
  return all;
}

std::vector<Usage> usages(const Path& path, const Motion& motion) {
  std::vector<Usage> all;
  for (std::size_t i = 0; i < path.position.size(); ++i) {
    Usage& u = all.emplace_back();
    u.position = spread_in(motion, path.position[i]);
    u.velocity = spread_in(motion, path.velocity[i]);
    widen_between_samples(u, path.velocity[i],
                          motion.duration / static_cast<double>(path.position[i].size()));
    u.duration = motion.duration;
  }
  return all;
}

void include(Spread& s, double value) {
  s.lower = std::min(s.lower, value);
  s.upper = std::max(s.upper, value);
}

/// Extends the ranges to `margin` before and after the motion; means stay those of the motion.
void include_margin(const MotionPath& path, const Motion& motion, double margin, const Coupling& to_encoders,
                    RobotUsage& usage) {
  constexpr int steps = 512;
  for (int k = 1; k <= steps; ++k) {
    const double beyond = margin * k / steps;
    for (const double t : {-beyond, motion.duration + beyond}) {
      const Eigen::VectorXd q = path.position(t), v = path.velocity(t);
      const Eigen::VectorXd x = to_encoders * q, u = to_encoders * v;
      for (Eigen::Index i = 0; i < q.size(); ++i) {
        const auto row = static_cast<std::size_t>(i);
        include(*usage.joints[row].position, q[i]);
        include(*usage.joints[row].velocity, v[i]);
        include(*usage.encoders[row].position, x[i]);
        include(*usage.encoders[row].velocity, u[i]);
      }
    }
  }
}

/// Widens the positions by half a count: the zero of an encoder is anywhere in a count.
void include_zeros(const Transmission& transmission, RobotUsage& usage) {
  const Eigen::VectorXd encoders = 0.5 * resolutions(transmission),
                        joints = transmission.coupling.magnitudes() * encoders;
  for (std::size_t i = 0; i < usage.joints.size(); ++i) {
    widen(*usage.joints[i].position, joints[i]);
    widen(*usage.encoders[i].position, encoders[i]);
  }
}

void add_efforts(const Chain& chain, const MotionPath& path, const Motion& motion,
                 std::vector<Usage>& joints) {
  Rows efforts(joints.size());
  for (const double t : instants(motion, most_efforts))
    append(efforts, inverse_dynamics(chain, path.position(t), path.velocity(t), path.acceleration(t)));
  for (std::size_t i = 0; i < joints.size(); ++i) joints[i].effort = spread_in(motion, efforts[i]);
}

}  // namespace

ErrorAlongMotion effects_along_motion(const OperationalModel& model, const std::vector<Effect>& effects,
                                      const Motion& motion, const std::vector<Filter>& filters,
                                      double settling) {
  ErrorAlongMotion error;
  error.tip = moments_of_tip(model, effects, UnroundedRecord(motion, motion.sample_rate, settling), nullptr,
                             &error.joints);
  for (const Filter& filter : filters)
    error.filtered.push_back(moments_of_tip(
        model, effects, UnroundedRecord(motion, filter.sample_rate, settling), &filter, nullptr));
  return error;
}

SignalMoments effect_along_motion(const OperationalModel& model, const Effect& effect, const Motion& motion,
                                  double settling) {
  const std::size_t row = independent_index(model.chain, effect.joint) * batch_size;
  const UnroundedRecord record(motion, motion.sample_rate, settling);
  MomentSums sums;
  record.read(model, {effect}, [&](const SensedBatch& batch, const std::vector<std::size_t>& used) {
    for (const std::size_t i : used)
      if (record.is_after_settling(batch.first + i))
        sums.add(Eigen::VectorXd::Constant(1, batch.measured[row + i] - batch.encoder[row + i]));
  });
  return sums.moments();
}

double change_with_zero(const OperationalModel& model, const std::vector<Effect>& effects,
                        std::size_t encoder, const Motion& motion, double settling) {
  const UnroundedRecord record(motion, motion.sample_rate, settling);
  const Eigen::VectorXd steps = resolutions(model.transmission);
  double largest_position = 0;
  const auto errors = [&](const Eigen::VectorXd& displacement) {
    std::vector<double> all;
    record.read(model, effects, displacement,
                [&](const SensedBatch& batch, const std::vector<std::size_t>& used) {
                  for (const std::size_t i : used) {
                    if (!record.is_after_settling(batch.first + i)) continue;
                    const double measured = batch.measured[encoder * batch_size + i];
                    largest_position = std::max(largest_position, std::abs(measured));
                    all.push_back(measured - batch.encoder[encoder * batch_size + i]);
                  }
                });
    return all;
  };
  const std::vector<double> before = errors(Eigen::VectorXd::Zero(steps.size()));
  double sum = 0;
  for (Eigen::Index e = 0; e < steps.size(); ++e) {
    // Another encoder displaces this one's joint through a coupling, or changes its load.
    const auto row = static_cast<Eigen::Index>(encoder);
    if (e != row && model.transmission.coupling(row, e) == 0 && !needs_effort(effects)) continue;
    double largest = 0;
    for (const double half : {-0.5, 0.5}) {
      const std::vector<double> after = errors(half * steps[e] * Eigen::VectorXd::Unit(steps.size(), e));
      for (std::size_t k = 0; k < before.size(); ++k)
        largest = std::max(largest, std::abs(after[k] - before[k]));
    }
    sum += largest;
  }
  constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();  // of the positions
  return sum > rounding * largest_position ? sum : 0;
}

RobotUsage usage_in_motion(const OperationalModel& model, const Motion& motion, double margin) {
  const MotionPath path(motion);
  const Coupling to_encoders = model.transmission.coupling.inverse();
  Path joints(path.joints()), encoders(path.joints());
  for (const double t : instants(motion, most_usage_samples)) {
    const Eigen::VectorXd q = path.position(t), v = path.velocity(t);
    append(joints.position, q);
    append(joints.velocity, v);
    append(encoders.position, to_encoders * q);
    append(encoders.velocity, to_encoders * v);
  }
  RobotUsage usage{usages(joints, motion), usages(encoders, motion)};
  if (margin > 0) include_margin(path, motion, margin, to_encoders, usage);
  include_zeros(model.transmission, usage);
  if (has_masses(model.chain)) add_efforts(model.chain, path, motion, usage.joints);
  return usage;
}

}  // namespace qerr
