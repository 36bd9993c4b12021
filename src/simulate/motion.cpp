#include <algorithm>
#include <cmath>
#include <numbers>

#include "lanes/batch.hpp"
#include "lanes/lanes.hpp"
#include "qerr/simulate/simulate.hpp"
#include "simulate/kernels.hpp"
#include "simulate/motion_path.hpp"

namespace qerr {

namespace {

constexpr double most_points = 1e6;  // at which the extent of a motion is evaluated

/// Durations of the phases of a point-to-point motion: jerk, constant acceleration, cruise. The deceleration
/// is symmetric to the acceleration.
struct Profile {
  double jerk_time = 0, acceleration_time = 0, cruise_time = 0;
  double acceleration = 0, jerk = 0;
};

/// The fastest motion from standstill to standstill over `distance` > 0 within the limits of the move.
Profile profile(const Move& move, double distance) {
  const double a = move.acceleration, j = move.jerk;
  double v = move.velocity;
  if (j == 0) {
    v = std::min(v, std::sqrt(a * distance));
    return {0, v / a, std::max(0.0, distance / v - v / a), a, 0};
  }
  // Acceleration to v takes t = v/a + a/j if a is reached, else 2 sqrt(v/j), over the distance v t/2.
  const auto reaches_limit = [&](double speed) { return speed * j >= a * a; };
  const auto acceleration_to = [&](double speed) {
    return reaches_limit(speed) ? speed / a + a / j : 2 * std::sqrt(speed / j);
  };
  if (v * acceleration_to(v) > distance) {
    v = 0.5 * a * (std::sqrt(a * a / (j * j) + 4 * distance / a) - a / j);
    if (!reaches_limit(v)) v = j * std::pow(distance / (2 * j), 2.0 / 3.0);
  }
  const double jerk_time = reaches_limit(v) ? a / j : std::sqrt(v / j);
  return {jerk_time, acceleration_to(v) - 2 * jerk_time, std::max(0.0, distance / v - acceleration_to(v)),
          j * jerk_time, j};
}

/// Slopes of the not-a-knot spline through the rows x(t), which is linear through two rows and a parabola
/// through three. Equal second derivatives at row i:
///
///     m_{i-1}/h_{i-1} + 2 m_i (1/h_{i-1} + 1/h_i) + m_{i+1}/h_i = 3 (d_{i-1}/h_{i-1} + d_i/h_i),
///
/// h the intervals and d the slopes of their chords; equal third derivatives at row 1:
///
///     h_1 m_0 + (h_0 + h_1) m_1 = ((3 h_0 + 2 h_1) h_1 d_0 + h_0^2 d_1)/(h_0 + h_1).
Eigen::RowVectorXd spline_slopes(const std::vector<double>& t, const Eigen::RowVectorXd& x) {
  const Eigen::Index n = x.size();
  Eigen::ArrayXd h(n - 1), d(n - 1);
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    h[i] = t[i + 1] - t[i];
    d[i] = (x[i + 1] - x[i]) / h[i];
  }
  if (n == 2) return Eigen::RowVectorXd::Constant(2, d[0]);
  if (n == 3) {
    const double c = (d[1] - d[0]) / (h[0] + h[1]);
    return Eigen::RowVector3d(d[0] - h[0] * c, d[0] + h[0] * c, d[1] + h[1] * c);
  }
  Eigen::ArrayXd below = Eigen::ArrayXd::Zero(n), diagonal = below, above = below, right = below;
  const auto end = [&](Eigen::Index row, double h0, double h1, double d0, double d1) {
    diagonal[row] = h1;
    right[row] = ((3 * h0 + 2 * h1) * h1 * d0 + h0 * h0 * d1) / (h0 + h1);
    return h0 + h1;
  };
  above[0] = end(0, h[0], h[1], d[0], d[1]);
  below[n - 1] = end(n - 1, h[n - 2], h[n - 3], d[n - 2], d[n - 3]);
  for (Eigen::Index i = 1; i + 1 < n; ++i) {
    below[i] = 1 / h[i - 1];
    above[i] = 1 / h[i];
    diagonal[i] = 2 * (below[i] + above[i]);
    right[i] = 3 * (d[i - 1] * below[i] + d[i] * above[i]);
  }
  for (Eigen::Index i = 1; i < n; ++i) {
    const double factor = below[i] / diagonal[i - 1];
    diagonal[i] -= factor * above[i - 1];
    right[i] -= factor * right[i - 1];
  }
  Eigen::RowVectorXd m(n);
  m[n - 1] = right[n - 1] / diagonal[n - 1];
  for (Eigen::Index i = n - 1; i-- > 0;) m[i] = (right[i] - above[i] * m[i + 1]) / diagonal[i];
  return m;
}

}  // namespace

/// Appends the phases of a move from standstill; the last one is the dwell. @returns its end [s]
double MotionPath::append(const Move& move, double from, double start, std::vector<Phase>& phases) {
  const double distance = std::abs(move.to - from), sign = move.to < from ? -1 : 1;
  double position = from, velocity = 0;
  const auto phase = [&](double length, double acceleration, double jerk) {
    if (length <= 0) return;
    phases.push_back({start, position, velocity, acceleration, jerk});
    position += length * (velocity + length * (acceleration / 2 + length * jerk / 6));
    velocity += length * (acceleration + length * jerk / 2);
    start += length;
  };
  if (distance > 0) {
    const Profile p = profile(move, distance);
    const double a = sign * p.acceleration, j = sign * p.jerk;
    phase(p.jerk_time, 0, j);
    phase(p.acceleration_time, a, 0);
    phase(p.jerk_time, a, -j);
    phase(p.cruise_time, 0, 0);
    phase(p.jerk_time, 0, -j);
    phase(p.acceleration_time, -a, 0);
    phase(p.jerk_time, -a, j);
  }
  phases.push_back({start, move.to, 0, 0, 0});
  return start + move.dwell;
}

MotionPath::MotionPath(const Motion& motion)
    : motion_(motion),
      count_(motion.joints.empty() ? static_cast<std::size_t>(motion.table.positions.rows())
                                   : motion.joints.size()) {
  const MotionTable& table = motion_.table;
  if (motion.joints.empty() && table.positions.cols() > 1) {
    slopes_.resizeLike(table.positions);
    for (Eigen::Index i = 0; i < slopes_.rows(); ++i)
      slopes_.row(i) = spline_slopes(table.time, table.positions.row(i));
  }
  for (const JointMotion& joint : motion_.joints) {
    std::vector<Oscillation>& oscillations = oscillations_.emplace_back();
    for (const Sine& sine : joint.sines)
      oscillations.push_back({sine.amplitude, 2 * std::numbers::pi * sine.frequency, sine.phase});
    Moves& moves = moves_.emplace_back();
    if (joint.moves.empty()) continue;
    double from = joint.center;
    for (const Move& move : joint.moves) {
      moves.first_end = append(move, from, moves.first_end, moves.first);
      from = move.to;
    }
    for (const Move& move : joint.moves) {
      moves.cycle_length = append(move, from, moves.cycle_length, moves.cycle);
      from = move.to;
    }
  }
}

MotionPath::MotionPath(MotionPath&&) noexcept = default;
MotionPath::~MotionPath() = default;

JointState MotionPath::of_phases(const std::vector<Phase>& phases, double time) {
  const auto next = std::ranges::upper_bound(phases, time, {}, &Phase::start);
  const Phase& p = next == phases.begin() ? *next : *std::prev(next);
  const double s = std::max(0.0, time - p.start);
  return {p.position + s * (p.velocity + s * (p.acceleration / 2 + s * p.jerk / 6)),
          p.velocity + s * (p.acceleration + s * p.jerk / 2), p.acceleration + s * p.jerk};
}

JointState MotionPath::of_moves(const Moves& moves, double time) {
  if (time < moves.first_end || moves.cycle_length == 0) return of_phases(moves.first, time);
  return of_phases(moves.cycle, std::fmod(time - moves.first_end, moves.cycle_length));
}

JointState MotionPath::of_table(std::size_t joint, double time) const {
  const std::vector<double>& t = motion_.table.time;
  const auto row = motion_.table.positions.row(joint);
  const auto last = std::ssize(t) - 1;
  const double row_time = t.front() + time;
  if (last == 0 || row_time < t.front()) return {row[0], 0, 0};
  if (row_time > t.back()) return {row[last], 0, 0};
  const auto next = std::ranges::upper_bound(t, row_time);
  const auto i = std::clamp<Eigen::Index>(next - t.begin() - 1, 0, last - 1);
  const auto at = [&](Eigen::Index k) { return t[k]; };
  const auto slope = slopes_.row(joint);
  const double h = at(i + 1) - at(i), s = (row_time - at(i)) / h;
  const double m0 = h * slope[i], m1 = h * slope[i + 1], rise = row[i + 1] - row[i];
  const double square = 3 * rise - 2 * m0 - m1, cube = m0 + m1 - 2 * rise;
  return {s == 1 ? row[i + 1] : row[i] + s * (m0 + s * (square + s * cube)),
          (m0 + s * (2 * square + 3 * s * cube)) / h, (2 * square + 6 * s * cube) / (h * h)};
}

double MotionPath::along(const RecordedSignal& signal, double time) const {
  const std::vector<double>& t = motion_.table.time;
  const double row_time = std::clamp(t.front() + time, t.front(), t.back());
  const auto next = std::ranges::upper_bound(t, row_time);
  if (next == t.end()) return signal.values[signal.values.size() - 1];
  const Eigen::Index i = next - t.begin();
  const double part = (row_time - *(next - 1)) / (*next - *(next - 1));
  return signal.values[i - 1] + part * (signal.values[i] - signal.values[i - 1]);
}

bool states_any(const std::vector<RecordedSignal>& signals) {
  return std::ranges::any_of(signals, [](const RecordedSignal& s) { return s.values.size() > 0; });
}

JointState MotionPath::at(std::size_t joint, double time) const {
  if (motion_.joints.empty()) return of_table(joint, time);
  const JointMotion& m = motion_.joints[joint];
  if (!m.moves.empty()) return of_moves(moves_[joint], time);
  JointState state{m.center + m.velocity * time, m.velocity, 0};
  for (const Sine& sine : m.sines) {
    const double rate = 2 * std::numbers::pi * sine.frequency, argument = rate * time + sine.phase;
    const double sine_part = sine.amplitude * std::sin(argument);
    state.position += sine_part;
    state.velocity += sine.amplitude * rate * std::cos(argument);
    state.acceleration -= rate * rate * sine_part;
  }
  return state;
}

bool MotionPath::within_lanes(const std::vector<Oscillation>& oscillations, const double* time) const {
  const double latest = std::max(std::abs(time[0]), std::abs(time[batch_size - 1]));
  return std::ranges::all_of(oscillations, [&](const Oscillation& o) {
    return std::abs(o.rate) * latest + std::abs(o.phase) <= lanes::largest_angle;
  });
}

void MotionPath::positions(std::size_t joint, const double* time, double* out, InstructionSet set) const {
  if (motion_.joints.empty() || !motion_.joints[joint].moves.empty() ||
      !within_lanes(oscillations_[joint], time)) {
    for (std::size_t i = 0; i < batch_size; ++i) out[i] = position(joint, time[i]);
    return;
  }
  const JointMotion& m = motion_.joints[joint];
  const std::vector<Oscillation>& oscillations = oscillations_[joint];
  select_kernels<SimulationKernels>(set).positions(
      {m.center, m.velocity, oscillations.data(), oscillations.size()}, time, out);
}

Eigen::VectorXd MotionPath::position(double time) const {
  Eigen::VectorXd q(count_);
  for (std::size_t i = 0; i < count_; ++i) q[i] = at(i, time).position;
  return q;
}

Eigen::VectorXd MotionPath::velocity(double time) const {
  Eigen::VectorXd v(count_);
  for (std::size_t i = 0; i < count_; ++i) v[i] = at(i, time).velocity;
  return v;
}

Eigen::VectorXd MotionPath::acceleration(double time) const {
  Eigen::VectorXd a(count_);
  for (std::size_t i = 0; i < count_; ++i) a[i] = at(i, time).acceleration;
  return a;
}

Eigen::MatrixX2d extent(const Motion& motion) {
  const MotionPath path(motion);
  Eigen::MatrixX2d range(path.joints(), 2);
  const double samples = std::floor(motion.duration * motion.sample_rate + 0.5);
  const double points = std::min(samples, most_points), step = samples / std::max(points, 1.0);
  for (std::size_t i = 0; i < path.joints(); ++i) {
    double low = path.position(i, 0), high = low;
    for (double k = 1; k <= points; ++k) {
      const double sample = k == points ? std::max(0.0, samples - 1) : std::floor(k * step);
      const double q = path.position(i, sample / motion.sample_rate);
      low = std::min(low, q);
      high = std::max(high, q);
    }
    range.row(i) << low, high;
  }
  return range;
}

}  // namespace qerr
