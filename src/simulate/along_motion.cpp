#include "simulate/along_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>

#include "bound/signal_errors.hpp"
#include "filter/run/cascade.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "lanes/batch.hpp"
#include "simulate/motion_path.hpp"
#include "simulate/run.hpp"
#include "simulate/sensing.hpp"
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

constexpr std::size_t lanes = 8;     // of a row; the widest vectors
constexpr int most_derivatives = 2;  // that the recursion along the chain gives

/// The filter's input and its ideal output at an instant, in the base frame.
struct TrueSignal {
  Eigen::Vector3d position, derivative;
  Eigen::Matrix3d axes;
};

class TrueMotion {
 public:
  TrueMotion(const Chain& chain, const Motion& motion, int derivative)
      : chain_(chain), path_(motion), derivative_(derivative) {}

  TrueSignal operator()(double time) const {
    const TipMotion tip =
        tip_motion(chain_, path_.position(time), path_.velocity(time), path_.acceleration(time));
    const Eigen::Vector3d position = tip.pose.translation();
    return {position,
            derivative_ == 0   ? position
            : derivative_ == 1 ? tip.velocity
                               : tip.acceleration,
            tip.pose.linear()};
  }

 private:
  Chain chain_;
  MotionPath path_;
  int derivative_;
};

/// Filters the tip's position, relative to where it starts: a filter of constants would lose digits.
class TrackingFilter {
 public:
  TrackingFilter(const Filter& filter, const Eigen::Vector3d& start)
      : filter_(filter, lanes, 1),
        in_(lanes),
        out_(lanes),
        start_(start),
        constant_(dc_gain(filter) * start) {
    filter_.settle(in_.data());
  }

  /// Output minus the ideal one, in the base frame.
  Eigen::Vector3d error(const TrueSignal& s) {
    for (Eigen::Index i = 0; i < 3; ++i) in_[i] = s.position[i] - start_[i];
    filter_(in_.data(), lanes, 1, out_.data());
    return Eigen::Vector3d(out_[0], out_[1], out_[2]) + constant_ - s.derivative;
  }

 private:
  RowFilter filter_;
  AlignedNumbers in_, out_;
  Eigen::Vector3d start_, constant_;  // input at the start, and the output for it as a constant
};

/// Sums of products of two signals.
struct Products {
  double count = 0, y = 0, yy = 0, e = 0, ye = 0, peak = 0;

  void add(double tracking, double effect) {
    count += 1;
    y += tracking;
    yy += tracking * tracking;
    e += effect;
    ye += tracking * effect;
    peak = std::max(peak, std::abs(tracking));
  }

  TrackingMoments moments() const {
    const double mean = y / count;
    return {mean, std::max(0.0, yy / count - mean * mean), peak, ye / count - mean * (e / count)};
  }
};

/// Filtered errors of the effects, [sample][coordinate].
class EffectErrors {
 public:
  EffectErrors(const OperationalModel& model, const std::vector<Effect>& effects, const Filter& filter)
      : any_(!effects.empty()),
        width_((model.coordinates.size() + lanes - 1) / lanes * lanes),
        errors_(model, as_built(model.chain, effects), Eigen::VectorXd::Zero(std::ssize(model.coordinates))),
        filter_(filter, width_, batch_size),
        rows_(width_ * batch_size),
        filtered_(width_ * batch_size) {}

  void run(const SensedBatch& batch, const std::vector<std::size_t>& used) {
    if (!any_) return;
    errors_(batch);
    for (std::size_t k = 0; k < used.size(); ++k)
      std::copy_n(errors_.rows() + used[k] * errors_.width(), std::min(width_, errors_.width()),
                  rows_.data() + k * width_);
    if (batch.first == 0) filter_.settle(rows_.data());
    filter_(rows_.data(), width_, used.size(), filtered_.data());
  }

  double at(std::size_t k, std::size_t coordinate) const {
    return any_ ? filtered_[k * width_ + coordinate] : 0;
  }

 private:
  bool any_;
  std::size_t width_;
  PathErrors errors_;
  RowFilter filter_;
  AlignedNumbers rows_, filtered_;
};

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

TipMotion tip_motion(const Chain& chain, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity,
                     const Eigen::VectorXd& acceleration) {
  using Eigen::Vector3d;
  TipMotion tip;
  Vector3d w = Vector3d::Zero(), alpha = Vector3d::Zero(), origin = Vector3d::Zero();
  // Moves the velocities from `origin` to a point that is fixed in the frame.
  const auto move_to = [&](const Vector3d& point) {
    const Vector3d step = point - origin;
    tip.velocity += w.cross(step);
    tip.acceleration += alpha.cross(step) + w.cross(w.cross(step));
    origin = point;
  };
  for (const ChainJoint& joint : chain.joints) {
    const auto i = static_cast<Eigen::Index>(joint.coordinate);
    const double s = joint.multiplier * q[i] + joint.offset;
    const double v = joint.multiplier * velocity[i], dv = joint.multiplier * acceleration[i];
    tip.pose = tip.pose * joint.origin;
    const Vector3d axis = tip.pose.linear() * joint.axis;
    if (joint.prismatic) {
      tip.pose.translate(s * joint.axis);
      move_to(tip.pose.translation());
      tip.velocity += v * axis;
      tip.acceleration += 2 * v * w.cross(axis) + dv * axis;
    } else {
      move_to(tip.pose.translation());
      tip.pose.rotate(Eigen::AngleAxisd(s, joint.axis));
      alpha += dv * axis + v * w.cross(axis);
      w += v * axis;
    }
  }
  tip.pose = tip.pose * chain.tip_offset;
  move_to(tip.pose.translation());
  return tip;
}

std::vector<TrackingMoments> tracking_along_motion(const OperationalModel& model,
                                                   const std::vector<Effect>& effects, const Motion& motion,
                                                   const Filter& filter, double settling) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  std::vector<TrackingMoments> moments(model.coordinates.size(), {unknown, unknown, unknown, unknown});
  if (filter.derivative > most_derivatives) return moments;
  const UnroundedRecord record(motion, filter.sample_rate, settling);
  const TrueMotion truth(as_built(model.chain, effects), motion, filter.derivative);
  const auto before = static_cast<std::int64_t>(std::ceil(settling * filter.sample_rate));
  const auto early = [&](std::int64_t samples) { return -static_cast<double>(samples) / filter.sample_rate; };
  TrackingFilter tracking(filter, truth(early(before)).position);
  for (std::int64_t k = before; k > 0; --k) tracking.error(truth(early(k)));
  EffectErrors of_effects(model, effects, filter);
  std::vector<Products> products(model.coordinates.size());
  record.read(model, effects, [&](const SensedBatch& batch, const std::vector<std::size_t>& used) {
    of_effects.run(batch, used);
    for (std::size_t k = 0; k < used.size(); ++k) {
      const std::uint64_t sample = batch.first + used[k];
      const TrueSignal signal = truth(static_cast<double>(sample) / motion.sample_rate);
      Eigen::Vector3d error = tracking.error(signal);
      if (!record.is_after_settling(sample)) continue;
      if (model.frame == CoordinateFrame::tip) error = (signal.axes.transpose() * error).eval();
      for (std::size_t c = 0; c < products.size(); ++c)
        if (is_position(model.coordinates[c]))
          products[c].add(error[static_cast<Eigen::Index>(model.coordinates[c])], of_effects.at(k, c));
    }
  });
  for (std::size_t c = 0; c < moments.size(); ++c)
    if (is_position(model.coordinates[c])) moments[c] = products[c].moments();
  return moments;
}

}  // namespace qerr
