#include "diagnose/plan/better_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/text.hpp"
#include "simulate/motion_path.hpp"

namespace qerr {

namespace {

constexpr double margin = 0.05;      ///< share of the range that is kept free at either end
constexpr double speed_share = 0.8;  ///< of the velocity limit

/// Range and highest speed of a joint in a candidate motion.
struct MotionRange {
  double low = 0, high = 0, speed = 0;  ///< speed 0: unknown
};

MotionRange motion_range(const IndependentJoint& joint, double now_low, double now_high, double now_speed) {
  MotionRange r{now_low, now_high, now_speed};
  if (joint.limits) {
    const double kept = margin * (joint.limits->upper - joint.limits->lower);
    r.low = std::min(now_low, joint.limits->lower + kept);
    r.high = std::max(now_high, joint.limits->upper - kept);
  } else if (!joint.prismatic()) {
    const double middle = 0.5 * (now_low + now_high);
    r.low = std::min(now_low, middle - 2 * std::numbers::pi);
    r.high = std::max(now_high, middle + 2 * std::numbers::pi);
  }
  if (joint.velocity_limit && *joint.velocity_limit > 0)
    r.speed = std::max(now_speed, speed_share * *joint.velocity_limit);
  return r;
}

/// Moves in both directions over a part of the range, repeated `cycles` times in the duration.
JointMotion moves(const MotionRange& r, double part, double cycles, double duration) {
  const double middle = 0.5 * (r.low + r.high), half = 0.5 * part * (r.high - r.low);
  // Targets relative to half the range, and speeds relative to the highest one.
  constexpr double legs[][2] = {{1, 1},      {-0.93, 0.6}, {0.31, 0.27}, {-0.47, 1},
                                {0.77, 0.6}, {-1, 1},      {-0.2, 0.27}};
  double path = 0, from = -0.2;  // length of the legs, weighted with 1/speed
  for (const auto& [to, speed] : legs) {
    path += std::abs(to - from) / speed;
    from = to;
  }
  const double dwell = 0.015 * duration / cycles, ramp = 0.02 * duration / cycles;
  const double moving = duration / cycles * 0.97 - 7 * (dwell + ramp);
  const double fast = std::min(r.speed > 0 ? r.speed : half * path / moving, half * path / moving);
  JointMotion m;
  m.center = rounded_to(middle - 0.2 * half, 3);
  for (const auto& [to, speed] : legs) {
    const double v = rounded_to(speed * fast, 3);
    m.moves.push_back(
        {rounded_to(middle + to * half, 3), v, rounded_to(fast / ramp, 3), 0, rounded_to(dwell, 3)});
  }
  return m;
}

/// A slow sine over the range, and two smaller, faster ones.
JointMotion sines(const MotionRange& r, double part, double cycles, double duration) {
  const double half = 0.5 * part * (r.high - r.low);
  constexpr double amplitudes[] = {0.72, 0.2, 0.08}, rates[] = {1, 3.37, 7.73};
  double f = cycles / duration, speed = 0;
  for (int i = 0; i < 3; ++i) speed += 2 * std::numbers::pi * f * rates[i] * amplitudes[i] * half;
  if (r.speed > 0) f *= std::min(1.0, r.speed / speed);
  JointMotion m;
  m.center = rounded_to(0.5 * (r.low + r.high), 3);
  for (int i = 0; i < 3; ++i)
    m.sines.push_back({rounded_to(amplitudes[i] * half, 3), rounded_to(f * rates[i], 3), 0});
  return m;
}

/// Rounding may have exceeded the limits.
bool within(const IndependentJoint& joint, const JointMotion& m, const Motion& like) {
  if (!joint.limits) return true;
  Motion one = like;
  one.joints = {m};
  one.table = {};
  const Eigen::MatrixX2d range = extent(one);
  return range(0, 0) >= joint.limits->lower && range(0, 1) <= joint.limits->upper;
}

}  // namespace

std::vector<std::vector<JointMotion>> better_motions(const OperationalModel& model, const Motion& motion) {
  const MotionPath path(motion);
  const Eigen::MatrixX2d range = extent(motion);
  std::vector<std::vector<JointMotion>> all;
  for (std::size_t j = 0; j < path.joints(); ++j) {
    const IndependentJoint& joint = model.chain.independent[j];
    double speed = 0;
    for (int k = 0; k <= 1000; ++k)
      speed = std::max(speed, std::abs(path.at(j, motion.duration * k / 1000).velocity));
    const auto row = static_cast<Eigen::Index>(j);
    const MotionRange r = motion_range(joint, range(row, 0), range(row, 1), speed);
    std::vector<JointMotion>& list = all.emplace_back();
    if (!(r.high > r.low)) continue;
    const double now = (range(row, 1) - range(row, 0)) / (r.high - r.low);
    for (const double part : {now, 0.5, 1.0}) {
      if (part < std::max(0.05, now)) continue;
      for (const double cycles : {1.0, 3.0})
        for (const auto& make : {moves, sines}) {
          JointMotion m = make(r, part, cycles, motion.duration);
          if (within(joint, m, motion)) list.push_back(std::move(m));
        }
    }
  }
  return all;
}

}  // namespace qerr
