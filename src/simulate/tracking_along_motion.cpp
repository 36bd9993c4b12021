#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/run/cascade.hpp"
#include "lanes/batch.hpp"
#include "simulate/along_motion.hpp"
#include "simulate/motion_path.hpp"
#include "simulate/run.hpp"
#include "simulate/sensing.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr {

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

namespace {

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
