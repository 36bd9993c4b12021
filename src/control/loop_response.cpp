#include "control/loop_response.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "control/kernels.hpp"
#include "control/loop.hpp"
#include "core/lists.hpp"
#include "filter/run/cascade.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "lanes/batch.hpp"

namespace qerr {

namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

// A response ends where two blocks of samples, each an eighth longer than that before, have added less than
// `negligible` of the sum.
constexpr std::size_t first_block = 256, most_samples = 4'000'000;
constexpr double negligible = 1e-11;

/// Motion of M q'' + b q' = u over a time t under a constant torque: q += q_of_v v + q_of_u u, v = v_of_v v +
/// v_of_u u.
struct Step {
  double q_of_v, q_of_u, v_of_v, v_of_u;
};

Step step_of(double inertia, double damping, double t) {
  const double x = damping * t / inertia;
  const double first = x == 0 ? 1 : -std::expm1(-x) / x;  // (1 - e^-x)/x
  // (1 - first)/x, by its series where the difference would lose digits.
  double second = 0.5;
  if (x > 0.1) {
    second = (1 - first) / x;
  } else {
    double term = 0.5;
    for (int k = 3; k < 16; ++k) second += term *= -x / k;
  }
  return {t * first, t * t * second / inertia, std::exp(-x), t * first / inertia};
}

void move(const Step& s, double u, double& q, double& v) {
  q += s.q_of_v * v + s.q_of_u * u;
  v = s.v_of_v * v + s.v_of_u * u;
}

/// Sums of |h| over blocks of growing length, until they vanish beside the whole.
class Decay {
 public:
  /// @returns whether the response has decayed
  bool add(double motion, double torque) {
    motion_.block += std::abs(motion);
    torque_.block += std::abs(torque);
    if (++count_ < length_) return false;
    count_ = 0;
    length_ += length_ / 8;
    const bool still = motion_.close();
    const bool idle = torque_.close();  // whatever the motion's block says, that of the torque ends
    quiet_ = still && idle ? quiet_ + 1 : 0;
    return quiet_ == 2;
  }
  bool finite() const { return std::isfinite(motion_.total) && std::isfinite(torque_.total); }

 private:
  struct Sum {
    double total = 0, block = 0;
    bool close() {
      const double added = std::exchange(block, 0);
      total += added;
      return added <= negligible * total;
    }
  };
  Sum motion_, torque_;
  std::size_t count_ = 0, length_ = first_block;
  int quiet_ = 0;
};

/// @param sign  of the response to an error: -L/(1 + L) and -C/(1 + L)
ResponseNorms certified(const Filter& f, double sign) {
  const Norms n = norms(f);
  return {n.l1.upper, n.h2, sign * n.dc_gain};
}

LoopNorms certified_norms(const Control& control, std::size_t joint) {
  constexpr ResponseNorms unstable{endless, endless, endless};
  const std::optional<ClosedLoop> loop = closed(loop_of(control, joint, *control.joints[joint].inertia));
  if (!loop) return {unstable, unstable};
  return {certified(loop->motion, -1), certified(loop->torque, -1)};
}

/// Up to `loops_of_run` loops, from a unit error at the first sample until all have decayed.
class LoopRun {
 public:
  LoopRun(const JointController& c, const double* inertias, std::size_t count, double sample_rate,
          double delay)
      : filter_(filter_plan<double>(c.kd != 0 ? c.velocity_filter : Filter{{}, 1, sample_rate, 0, {1}})),
        before_(4 * loops_of_run),
        after_(4 * loops_of_run) {
    const double whole = std::floor(delay), late = delay - whole;
    plan_ = {c.kp * c.reading.factor,
             c.kd * c.reading.factor,
             filter_.sections.data(),
             filter_.sections.size(),
             filter_.taps.data(),
             filter_.taps.size(),
             static_cast<std::size_t>(whole),
             late > 0,
             before_.data(),
             after_.data()};
    rows_ = AlignedNumbers(LoopRows::count(plan_) * loops_of_run);
    for (std::size_t i = 0; i < loops_of_run; ++i) {
      running_[i] = i < count && inertias[i] > 0;
      const double inertia = running_[i] ? inertias[i] : 1, damping = c.damping.value_or(0);
      set(before_, i, step_of(inertia, damping, late / sample_rate));
      set(after_, i, step_of(inertia, damping, (1 - late) / sample_rate));
      at(LoopRows::error, i) = running_[i] ? 1 / c.reading.factor : 0;
    }
  }

  LoopRun(const LoopRun&) = delete;  // the plan borrows
  LoopRun& operator=(const LoopRun&) = delete;

  /// Norms of each loop, infinite of one that has not decayed.
  std::array<LoopNorms, loops_of_run> run() {
    constexpr ResponseNorms unstable{endless, endless, endless};
    std::array<LoopNorms, loops_of_run> norms;
    norms.fill({unstable, unstable});
    const LoopKernels& kernels = select_kernels<LoopKernels>(instruction_set());
    std::array<int, loops_of_run> quiet{};
    for (std::size_t done = 0, length = first_block; done < most_samples && contains(running_, true);
         length += length / 8) {
      kernels.run(plan_, rows_.data(), done, length);
      done += length;
      for (std::size_t i = 0; i < loops_of_run; ++i) {
        if (!running_[i]) continue;
        const bool still = close(motion_, LoopRows::sums, i);
        const bool idle = close(torque_, LoopRows::sums + 3, i);
        quiet[i] = still && idle ? quiet[i] + 1 : 0;
        const bool decayed = quiet[i] == 2;
        if (decayed)
          norms[i] = {norms_of(motion_, LoopRows::sums, i), norms_of(torque_, LoopRows::sums + 3, i)};
        if (decayed || !std::isfinite(motion_[i] + torque_[i])) stop(i);
      }
    }
    return norms;
  }

 private:
  using Sums = std::array<double, loops_of_run>;

  static void set(const AlignedNumbers& to, std::size_t loop, const Step& s) {
    const double values[] = {s.q_of_v, s.q_of_u, s.v_of_v, s.v_of_u};
    for (std::size_t row = 0; row < 4; ++row) to[row * loops_of_run + loop] = values[row];
  }
  double& at(std::size_t row, std::size_t loop) { return rows_[row * loops_of_run + loop]; }

  /// Ends a block of |h|. @returns whether it is small beside the whole
  bool close(Sums& total, std::size_t row, std::size_t loop) {
    const double block = std::exchange(at(row, loop), 0);
    total[loop] += block;
    return block <= negligible * total[loop];
  }
  ResponseNorms norms_of(const Sums& total, std::size_t row, std::size_t loop) {
    return {total[loop], std::sqrt(at(row + 1, loop)), at(row + 2, loop)};
  }

  /// Ends a loop, whose states would become denormal, or infinite.
  void stop(std::size_t loop) {
    running_[loop] = false;
    for (std::size_t row = 0; row < LoopRows::count(plan_); ++row) at(row, loop) = 0;
  }

  FilterPlan<double> filter_;
  AlignedNumbers before_, after_, rows_;
  LoopPlan plan_;
  std::array<bool, loops_of_run> running_{};
  Sums motion_{}, torque_{};  // of |h| in the blocks that have ended
};

}  // namespace

LoopResponse loop_response(const JointController& c, double inertia, double sample_rate, double delay) {
  const double damping = c.damping.value_or(0), whole = std::floor(delay), late = delay - whole;
  const Step before = step_of(inertia, damping, late / sample_rate),
             after = step_of(inertia, damping, (1 - late) / sample_rate);
  std::vector<double> torques(static_cast<std::size_t>(whole) + 2);  // a ring, the newest at k
  Filter nothing{{}, 1, sample_rate, 0, {1}};
  Cascade<double> velocity(c.kd != 0 ? c.velocity_filter : nothing);
  LoopResponse r;
  Decay decay;
  double q = 0, v = 0;
  const double factor = c.reading.factor;
  const std::size_t size = torques.size();
  for (std::size_t k = 0; k < most_samples; ++k) {
    const double reading = factor * q + (k == 0 ? 1 : 0);
    const double u = -c.kp * reading - (c.kd != 0 ? c.kd * velocity.step(reading) : 0);
    torques[k % size] = u;
    r.motion.push_back(q);
    r.torque.push_back(u);
    // Torques are due `delay` after their reading: that of a sample earlier until `late` after this one.
    if (late > 0) move(before, torques[(k + 1) % size], q, v);
    move(after, torques[(k + size - static_cast<std::size_t>(whole)) % size], q, v);
    if (decay.add(r.motion.back(), u)) {
      r.stable = true;
      return r;
    }
    if (!std::isfinite(q) || !decay.finite()) break;
  }
  return {};
}

ResponseNorms response_norms(const LoopResponse& r, const std::vector<double> LoopResponse::*of) {
  if (!r.stable) return {endless, endless, endless};
  return norms_of_sum({&(r.*of)}, {1});
}

ResponseNorms norms_of_sum(const std::vector<const std::vector<double>*>& responses,
                           const std::vector<double>& weights) {
  std::size_t longest = 0;
  for (const auto* r : responses) longest = std::max(longest, r->size());
  ResponseNorms n;
  double squares = 0;
  for (std::size_t k = 0; k < longest; ++k) {
    double h = 0;
    for (std::size_t i = 0; i < responses.size(); ++i)
      if (k < responses[i]->size()) h += weights[i] * (*responses[i])[k];
    n.l1 += std::abs(h);
    n.dc += h;
    squares += h * h;
  }
  n.h2 = std::sqrt(squares);
  return n;
}

double inertia_at(const Control& control, const Chain& chain, std::size_t joint, const Eigen::VectorXd& q) {
  const std::optional<double>& stated = control.joints[joint].inertia;
  return stated ? *stated : inertia_at(chain, joint, q);
}

bool has_loop(const Control& control, const Chain& chain, std::size_t joint) {
  const JointController& c = control.joints[joint];
  return c.acts() && (c.inertia || has_masses(chain));
}

bool close_the_same(const JointController& x, const JointController& y) {
  return x.kp == y.kp && x.kd == y.kd && x.velocity == y.velocity && x.damping == y.damping &&
         x.inertia == y.inertia && x.reading == y.reading;
}

std::vector<LoopNorms> loop_norms(const JointController& c, const std::vector<double>& inertias,
                                  double sample_rate, double delay) {
  std::vector<LoopNorms> all;
  for (std::size_t i = 0; i < inertias.size(); i += loops_of_run) {
    const std::size_t count = std::min(loops_of_run, inertias.size() - i);
    const auto some = LoopRun(c, inertias.data() + i, count, sample_rate, delay).run();
    all.insert(all.end(), some.begin(), some.begin() + count);
  }
  return all;
}

Control with_stated_loops(Control control) {
  const std::size_t count = control.joints.size();
  control.stated.assign(count, nullptr);
  for (std::size_t j = 0; j < count; ++j) {
    if (!control.joints[j].inertia) continue;
    for (std::size_t k = 0; k < j && !control.stated[j]; ++k)
      if (control.stated[k] && close_the_same(control.joints[k], control.joints[j]))
        control.stated[j] = control.stated[k];
    if (!control.stated[j]) control.stated[j] = std::make_shared<StatedLoop>();
  }
  return control;
}

LoopsOfBatch::LoopsOfBatch(std::shared_ptr<const Control> control, const Chain& chain)
    : control_(std::move(control)), chain_(chain), joints_(control_ ? control_->joints.size() : 0) {}

void LoopsOfBatch::move_to(Eigen::MatrixXd q) {
  q_ = std::move(q);
  for (OfJoint& joint : joints_) joint = {};
}

LoopsOfBatch::OfJoint& LoopsOfBatch::of_joint(std::size_t joint) {
  OfJoint& of = joints_[joint];
  if (!of.inertias.empty()) return of;
  for (Eigen::Index i = 0; i < q_.cols(); ++i)
    of.inertias.push_back(inertia_at(*control_, chain_, joint, q_.col(i)));
  of.responses.resize(of.inertias.size());
  return of;
}

const LoopNorms& LoopsOfBatch::norms(std::size_t joint, Eigen::Index configuration) {
  if (joint < control_->stated.size() && control_->stated[joint]) {
    StatedLoop& stated = *control_->stated[joint];
    std::call_once(stated.of_norms, [&] { stated.norms = certified_norms(*control_, joint); });
    return stated.norms;
  }
  OfJoint& of = of_joint(joint);
  if (of.norms.empty()) {
    std::vector<double> different = of.inertias;
    std::ranges::sort(different);
    different.erase(std::unique(different.begin(), different.end()), different.end());
    const std::vector<LoopNorms> all = loop_norms(control_->joints[joint], different, control_->sample_rate,
                                                  control_->samples_of_delay(joint));
    for (const double inertia : of.inertias)
      of.norms.push_back(all[std::ranges::lower_bound(different, inertia) - different.begin()]);
  }
  return of.norms[configuration];
}

const LoopResponse& LoopsOfBatch::response(std::size_t joint, Eigen::Index configuration) {
  const auto evaluated = [&](double inertia) {
    return inertia > 0 ? loop_response(control_->joints[joint], inertia, control_->sample_rate,
                                       control_->samples_of_delay(joint))
                       : LoopResponse{};
  };
  if (joint < control_->stated.size() && control_->stated[joint]) {
    StatedLoop& stated = *control_->stated[joint];
    std::call_once(stated.of_response,
                   [&] { stated.response = evaluated(*control_->joints[joint].inertia); });
    return stated.response;
  }
  OfJoint& of = of_joint(joint);
  const auto i = static_cast<std::size_t>(configuration);
  if (!of.responses[i]) of.responses[i] = evaluated(of.inertias[i]);
  return *of.responses[i];
}

}  // namespace qerr
