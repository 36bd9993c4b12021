#include "control/loop_response.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "control/loop.hpp"
#include "filter/run/cascade.hpp"
#include "kinematics/inverse_dynamics.hpp"

namespace qerr {

namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

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
    const bool small = motion_.close() & torque_.close();
    quiet_ = small ? quiet_ + 1 : 0;
    return quiet_ == 2;
  }
  bool finite() const { return std::isfinite(motion_.total) && std::isfinite(torque_.total); }

 private:
  struct Sum {
    double total = 0, block = 0;
    bool close() {
      const double added = std::exchange(block, 0);
      total += added;
      return added <= 1e-11 * total;
    }
  };
  Sum motion_, torque_;
  int count_ = 0, length_ = 256, quiet_ = 0;
};

}  // namespace

LoopResponse loop_response(const JointController& c, double inertia, double sample_rate, double delay) {
  constexpr std::size_t most_samples = 4'000'000;
  const double damping = c.damping.value_or(0), whole = std::floor(delay), late = delay - whole;
  const Step before = step_of(inertia, damping, late / sample_rate),
             after = step_of(inertia, damping, (1 - late) / sample_rate);
  std::vector<double> torques(static_cast<std::size_t>(whole) + 2);  // a ring, the newest at k
  Filter nothing{{}, 1, sample_rate, 0, {1}};
  Cascade<double> velocity(c.kd != 0 ? c.velocity_filter : nothing);
  LoopResponse r;
  Decay decay;
  double q = 0, v = 0;
  const std::size_t size = torques.size();
  for (std::size_t k = 0; k < most_samples; ++k) {
    const double reading = q + (k == 0 ? 1 : 0);
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

namespace {

/// @param sign  of the response to an error: -L/(1 + L) and -C/(1 + L)
ResponseNorms certified(const Filter& f, double sign) {
  const Norms n = norms(f);
  return {n.l1.upper, n.h2, sign * n.dc_gain};
}

/// Whether two joints of one controller close the same loop, at equal inertias.
bool close_the_same(const JointController& x, const JointController& y) {
  return x.kp == y.kp && x.kd == y.kd && x.velocity == y.velocity && x.damping == y.damping &&
         x.inertia.has_value() == y.inertia.has_value();
}

}  // namespace

const KnownResponse& response_at(const Control& control, const Chain& chain, std::size_t joint,
                                 const Eigen::VectorXd& q) {
  struct Kept {
    std::uint64_t control = 0;
    double inertia = -1;
    KnownResponse known;
  };
  static thread_local std::map<std::size_t, Kept> all;
  Kept& kept = all[joint];
  const double inertia = inertia_at(control, chain, joint, q);
  if (kept.control == control.id && kept.inertia == inertia) return kept.known;
  for (const auto& [other, of_other] : all)
    if (other != joint && of_other.control == control.id && of_other.inertia == inertia &&
        close_the_same(control.joints[other], control.joints[joint])) {
      kept = of_other;
      return kept.known;
    }
  kept = {control.id, inertia, {}};
  LoopResponse& r = kept.known.response;
  if (inertia > 0)
    r = loop_response(control.joints[joint], inertia, control.sample_rate, control.samples_of_delay());
  kept.known.motion = response_norms(r, &LoopResponse::motion);
  kept.known.torque = response_norms(r, &LoopResponse::torque);
  if (!control.joints[joint].inertia) return kept.known;
  // Once for all configurations: exact also of a loop that decays too slowly for the recursion.
  const std::optional<ClosedLoop> loop = closed(loop_of(control, joint, inertia));
  kept.known.motion = loop ? certified(loop->motion, -1) : ResponseNorms{endless, endless, endless};
  kept.known.torque = loop ? certified(loop->torque, -1) : ResponseNorms{endless, endless, endless};
  return kept.known;
}

}  // namespace qerr
