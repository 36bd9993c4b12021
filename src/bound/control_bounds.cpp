#include "bound/control_bounds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "control/loop_response.hpp"
#include "core/parallel.hpp"
#include "core/search.hpp"
#include "qerr/bound/independent_error.hpp"
#include "qerr/kinematics/chain.hpp"

namespace qerr {
/// The largest kd at which the torque keeps a limit; 0 if none does.
///
/// ||kp + kd H||_1 h + |kp + kd H(1)| |m| and ||kp + kd H||_2 sigma are convex in kd, so that below the
/// largest one there is a single crossing.
double largest_kd(const OperationalModel& model, std::size_t joint, Bound bound, double limit) {
  const JointController& c = model.control->joints[joint];
  const ResponseSums sums = response_sums(c.velocity_filter);
  const JointError error = joint_error(model);
  const auto met = [&](double kd) {
    const double torque = bound == Bound::worst_case
                              ? sums.l1(c.kp, kd) * error.half_width[joint] +
                                    std::abs(c.kp + kd * sums.dc) * std::abs(error.mean[joint])
                              : sums.h2(c.kp, kd) * error.sigma[joint];
    return torque <= limit;
  };
  double lower = met(c.kd) ? c.kd : 0;
  if (!met(lower)) return 0;
  double upper = c.kd;
  for (int i = 0; i < 1000 && met(upper); ++i) upper *= 2;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (lower + upper);
    (met(middle) ? lower : upper) = middle;
  }
  return lower;
}

namespace {

/// ||kp + kd H||_1 of the joint's own controller, or of each pair of joints of an impedance at the tip:
/// errors of joint j in the torque of a joint.
Eigen::RowVectorXd torque_norms(const OperationalModel& model, std::size_t joint, const Eigen::VectorXd& q,
                                const Eigen::MatrixXd& moved, const std::vector<ResponseSums>& sums) {
  const Control& control = *model.control;
  const auto row = static_cast<Eigen::Index>(joint);
  if (!control.tip)
    return moved.row(row).cwiseAbs() * sums[joint].l1(control.joints[joint].kp, control.joints[joint].kd);
  const Eigen::MatrixXd j = jacobian(model.chain, q).topRows<3>();
  const Eigen::RowVectorXd k = j.col(row).transpose() * control.tip->stiffness.asDiagonal() * j * moved,
                           d = j.col(row).transpose() * control.tip->damping.asDiagonal() * j * moved;
  Eigen::RowVectorXd norms(moved.cols());
  for (Eigen::Index e = 0; e < norms.size(); ++e) norms[e] = control.tip->velocity_sums.l1(k[e], d[e]);
  return norms;
}

/// Half of it is the largest error of a joint's reading that its counts make [rad or m].
double count_of(const OperationalModel& model, std::size_t joint) {
  const Transmission& t = model.transmission;
  return t.coupling.row(joint).cwiseAbs().dot(resolutions(t));
}

/// The range of a joint's inertia. @returns whether it is more than rounding
bool set_inertias(WorstLoop& r, const OperationalModel& model, const Eigen::MatrixXd& configurations) {
  const Control& control = *model.control;
  r.least_inertia = std::numeric_limits<double>::infinity();
  for (Eigen::Index c = 0; c < configurations.cols(); ++c) {
    const double inertia = inertia_at(control, model.chain, r.joint, configurations.col(c));
    r.least_inertia = std::min(r.least_inertia, inertia);
    r.largest_inertia = std::max(r.largest_inertia, inertia);
    if (control.joints[r.joint].inertia) break;
  }
  constexpr double rounding = 1e-9;
  return r.largest_inertia > r.least_inertia * (1 + rounding);
}

/// A loop at one inertia. The cycle is that of a stable loop.
struct LoopAtInertia {
  LoopMargins margins;
  LimitCycle cycle;
};

/// Figures of a loop, the larger the worse, of which the largest over the inertias is searched.
constexpr std::array<double (*)(const LoopAtInertia&), 7> dangers{
    [](const LoopAtInertia& l) { return -l.margins.gain; },
    [](const LoopAtInertia& l) { return l.margins.lower_gain; },
    [](const LoopAtInertia& l) { return -l.margins.phase.value_or(2 * std::numbers::pi); },
    [](const LoopAtInertia& l) {
      return -l.margins.bandwidth.value_or(std::numeric_limits<double>::infinity());
    },
    [](const LoopAtInertia& l) { return l.cycle.bound; },
    [](const LoopAtInertia& l) { return l.cycle.torque_bound; },
    [](const LoopAtInertia& l) { return l.cycle.edge_amplitude; }};

/// Half width of the error of a joint's reading that lasts at rest [rad or m].
double lasting_error(const OperationalModel& model, std::size_t joint) {
  const Transmission& t = model.transmission;
  Eigen::VectorXd widths = widths_at_rest(*model.control, resolutions(t));
  for (Eigen::Index j = 0; j < widths.size(); ++j)  // of the own joint, limit_cycle counts it by its slope
    if (static_cast<std::size_t>(j) != joint) widths[j] += 2 * model.control->joints[j].reading.of_position;
  return 0.5 * t.coupling.row(joint).cwiseAbs().dot(widths);
}

/// A joint's loop at inertias of its range, each evaluated once.
class LoopOfJoint {
 public:
  LoopOfJoint(const OperationalModel& model, std::size_t joint)
      : control_(*model.control),
        joint_(joint),
        count_(count_of(model, joint)),
        lasting_(lasting_error(model, joint)),
        step_(largest_step(controller())),
        controller_norm_(l1_norm(controller()).upper) {}

  /// The bounds of its cycle are those of the recursion.
  const LoopAtInertia& at(double inertia) {
    const auto [known, fresh] = all_.try_emplace(inertia);
    if (!fresh) return known->second;
    LoopAtInertia& l = known->second;
    l.margins = margins(loop_of(control_, joint_, inertia));
    if (!l.margins.stable) return l;
    const LoopNorms norms = loop_norms(control_.joints[joint_], {inertia}, control_.sample_rate,
                                       control_.samples_of_delay(joint_))[0];
    set_cycle(l, inertia, norms.motion.l1, norms.torque.l1);
    return l;
  }

  /// The bounds of the cycle by certified norms. @returns false for a loop that is too close to unstable
  bool certify(double inertia) {
    LoopAtInertia& l = all_.at(inertia);
    const std::optional<ClosedLoop> loop = closed(loop_of(control_, joint_, inertia));
    l.margins.stable = loop.has_value();
    if (loop) set_cycle(l, inertia, l1_norm(loop->motion).upper, l1_norm(loop->torque).upper);
    return l.margins.stable;
  }

  /// Certifies the largest bounds: where they are, and where a loop is too slow for the recursion.
  void certify_largest() {
    double motion = 0, torque = 0, of_motion = 0, of_torque = 0;
    for (const auto& [inertia, l] : all_) {
      if (!l.margins.stable || (std::isinf(l.cycle.bound) && !certify(inertia))) continue;
      if (l.cycle.bound > motion) motion = l.cycle.bound, of_motion = inertia;
      if (l.cycle.torque_bound > torque) torque = l.cycle.torque_bound, of_torque = inertia;
    }
    if (of_motion > 0) certify(of_motion);
    if (of_torque > 0 && of_torque != of_motion) certify(of_torque);
  }

  /// Evaluates a range in equal ratios, and then each figure about its worst: by golden sections between the
  /// neighbours, or, at an end of the range, no more where it falls from there.
  void search(double least, double largest) {
    constexpr int samples = 7, sections = 12;  // 0.618^12 of a ratio: 1e-5 of a smooth figure's curvature
    constexpr double beside = 0.01;            // of a ratio, from an end
    const double ratio = std::log(largest / least) / (samples - 1);
    const auto inertia = [&](double place) {
      return place <= 0 ? least : place >= samples - 1 ? largest : least * std::exp(ratio * place);
    };
    for (int i = 0; i < samples; ++i) at(inertia(i));
    for (const auto danger : dangers) {
      const auto of = [&](double place) { return danger(at(inertia(place))); };
      int worst = 0;
      for (int i = 1; i < samples; ++i)
        if (of(i) > of(worst)) worst = i;
      const double low = std::max(0, worst - 1), high = std::min(samples - 1, worst + 1);
      if (!std::isfinite(of(worst))) continue;
      if (low == worst && of(worst + beside) <= of(worst)) continue;
      if (high == worst && of(worst - beside) <= of(worst)) continue;
      golden_section(low, high, sections, of);
    }
  }

  const std::map<double, LoopAtInertia>& all() const { return all_; }

 private:
  Filter controller() const { return controller_of(control_.joints[joint_], control_.sample_rate); }

  void set_cycle(LoopAtInertia& l, double inertia, double motion, double torque) {
    const LoopReading& reading = control_.joints[joint_].reading;
    l.cycle = limit_cycle(l.margins, motion, torque, step_, reading, count_, lasting_);
    // Between two counts the set point is at most half a count from the edge, on which the reading changes.
    l.cycle.ending_friction = (controller_norm_ + std::abs(control_.joints[joint_].kp)) * lasting_;
    if (reading.play > 0)
      l.cycle.play = play_cycle(loop_of(control_, joint_, inertia), reading.play, reading.behind_play);
  }

  const Control control_;
  std::size_t joint_;
  double count_, lasting_, step_, controller_norm_;
  std::map<double, LoopAtInertia> all_;
};

template <class T>
void keep_least(std::optional<T>& kept, const std::optional<T>& other) {
  if (!kept || (other && *other < *kept)) kept = other;
}

/// The least margins and bandwidth of both.
void keep_least(LoopMargins& m, const LoopMargins& other) {
  if (other.gain < m.gain) {
    m.gain = other.gain;
    m.critical_frequency = other.critical_frequency;
  }
  m.lower_gain = std::max(m.lower_gain, other.lower_gain);
  if (other.phase && (!m.phase || *other.phase < *m.phase)) {
    m.phase = other.phase;
    m.crossover = other.crossover;
  }
  keep_least(m.bandwidth, other.bandwidth);
  m.absolutely_stable = m.absolutely_stable && other.absolutely_stable;
}

void keep_largest(LimitCycle& c, const LimitCycle& other) {
  c.bound = std::max(c.bound, other.bound);
  c.torque_bound = std::max(c.torque_bound, other.torque_bound);
  c.on_count = c.on_count || other.on_count;
  c.on_edge = c.on_edge || other.on_edge;
  if (other.edge_amplitude > c.edge_amplitude) {
    c.edge_amplitude = other.edge_amplitude;
    c.frequency = other.frequency;
  }
  if (other.play && (!c.play || other.play->amplitude > c.play->amplitude)) c.play = other.play;
}

WorstLoop worst_loop(const OperationalModel& model, std::size_t joint,
                     const Eigen::MatrixXd& configurations) {
  WorstLoop r;
  r.joint = joint;
  LoopOfJoint loop(model, joint);
  if (set_inertias(r, model, configurations))
    loop.search(r.least_inertia, r.largest_inertia);
  else
    loop.at(r.least_inertia);
  loop.certify_largest();
  for (const auto& [inertia, l] : loop.all())
    if (!l.margins.stable) {
      r.unstable_inertia = inertia;
      r.margins = l.margins;
      return r;
    }
  r.stable = true;
  r.margins = loop.all().begin()->second.margins;
  r.cycle = loop.all().begin()->second.cycle;
  for (const auto& [inertia, l] : loop.all()) {
    keep_least(r.margins, l.margins);
    keep_largest(r.cycle, l.cycle);
  }
  return r;
}

/// Whether two joints have one loop, of equal gains, inertias and counts.
bool have_one_loop(const OperationalModel& model, std::size_t a, std::size_t b) {
  const std::vector<JointController>& all = model.control->joints;
  return all[a].inertia && close_the_same(all[a], all[b]) && count_of(model, a) == count_of(model, b);
}

}  // namespace

/// The torques due to errors within their half widths; means are left out.
std::vector<OpenTorque> open_torques(const OperationalModel& model, const Eigen::MatrixXd& configurations) {
  const Control& control = *model.control;
  const Transmission& t = model.transmission;
  const auto& joints = model.chain.independent;
  std::vector<IndependentError> errors = independent_errors(model);
  std::erase_if(errors, [](const auto& e) { return e.where == IndependentError::Where::origin; });
  Eigen::MatrixXd moved(std::ssize(joints), std::ssize(errors));
  for (Eigen::Index e = 0; e < moved.cols(); ++e) moved.col(e) = moved_joints(t, errors[e]);
  std::vector<ResponseSums> sums(joints.size());
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (control.joints[j].kd > 0) sums[j] = response_sums(control.joints[j].velocity_filter);
  std::vector<OpenTorque> all;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (!control.tip && !control.joints[j].acts()) continue;
    OpenTorque r{j, 0, {}, Eigen::VectorXd::Zero(std::ssize(joints))};
    const Eigen::Index count = control.tip ? configurations.cols() : 1;
    for (Eigen::Index c = 0; c < count; ++c) {
      const Eigen::RowVectorXd norms = torque_norms(model, j, configurations.col(c), moved, sums);
      Eigen::VectorXd parts = Eigen::VectorXd::Zero(r.share.size());
      for (Eigen::Index e = 0; e < norms.size(); ++e) {
        const IndependentError& error = errors[e];
        parts[error.owner] += std::abs(norms[e]) * error.half_width;
      }
      if (!(parts.sum() > 0)) continue;
      r.worst_case = std::max(r.worst_case, parts.sum());
      r.share += parts / parts.sum() / static_cast<double>(count);
    }
    if (const auto& limit = joints[j].effort_limit; limit && *limit > 0) r.relative = r.worst_case / *limit;
    all.push_back(std::move(r));
  }
  return all;
}

std::vector<WorstLoop> worst_loops(const OperationalModel& model, const std::vector<std::size_t>& joints,
                                   const Eigen::MatrixXd& configurations) {
  std::vector<WorstLoop> loops(joints.size());
  std::vector<std::size_t> first(joints.size());  // the place of the first joint with the same loop
  for (std::size_t i = 0; i < joints.size(); ++i)
    while (first[i] < i && !have_one_loop(model, joints[first[i]], joints[i])) ++first[i];
  parallel_for(joints.size(), 0, [&](std::size_t i) {
    if (first[i] == i) loops[i] = worst_loop(model, joints[i], configurations);
  });
  for (std::size_t i = 0; i < joints.size(); ++i) {
    loops[i] = loops[first[i]];
    loops[i].joint = joints[i];
  }
  return loops;
}

WorstWall worst_wall(const OperationalModel& model, const Wall& wall, const Eigen::MatrixXd& configurations) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  WorstWall r{wall.name, {infinity, infinity, 0, 0}, infinity, infinity, {}};
  const Transmission& t = model.transmission;
  const Eigen::MatrixXd coupling = t.coupling.dense();
  const Eigen::VectorXd widths = widths_at_rest(*model.control, resolutions(t));
  for (Eigen::Index c = 0; c < configurations.cols(); ++c) {
    const Eigen::VectorXd q = configurations.col(c);
    const WallLimit limit = wall_limit(*model.control, felt_by(model.chain, wall, q), coupling, widths);
    r.sampling = std::min(r.sampling, limit.sampling);
    r.quantization = std::min(r.quantization, limit.quantization);
    if (r.at.size() > 0 && limit.stiffness() >= r.limit.stiffness()) continue;
    r.limit = limit;
    r.at = q;
  }
  return r;
}

}  // namespace qerr
