#include "report/analysis/control.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "control/figures.hpp"
#include "control/loop_response.hpp"
#include "core/parallel.hpp"
#include "core/search.hpp"
#include "core/text.hpp"
#include "qerr/bound/independent_error.hpp"
#include "qerr/kinematics/chain.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

constexpr double unknown_figure = std::numeric_limits<double>::quiet_NaN();

Eigen::MatrixXd first_configurations(const Spec& spec) {
  return draw(spec.configurations, 0, std::min(configurations_of_control, size(spec.configurations)));
}

/// The range of a joint's inertia. @returns whether it is more than rounding
bool set_inertias(LoopReport& r, const Spec& spec, const Eigen::MatrixXd& configurations) {
  const Control& control = *spec.model.control;
  r.least_inertia = std::numeric_limits<double>::infinity();
  for (Eigen::Index c = 0; c < configurations.cols(); ++c) {
    const double inertia = inertia_at(control, spec.model.chain, r.joint, configurations.col(c));
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

/// Half of it is the largest error of a joint's reading that its counts make [rad or m].
double count_of(const Spec& spec, std::size_t joint) {
  const Transmission& t = spec.model.transmission;
  return t.coupling.row(static_cast<Eigen::Index>(joint)).cwiseAbs().dot(resolutions(t));
}

/// Half width of the error of a joint's reading that lasts at rest [rad or m].
double lasting_error(const Spec& spec, std::size_t joint) {
  const Transmission& t = spec.model.transmission;
  Eigen::VectorXd widths = widths_at_rest(*spec.model.control, resolutions(t));
  for (Eigen::Index j = 0; j < widths.size(); ++j)  // of the own joint, limit_cycle counts it by its slope
    if (static_cast<std::size_t>(j) != joint)
      widths[j] += 2 * spec.model.control->joints[static_cast<std::size_t>(j)].reading.of_position;
  return 0.5 * t.coupling.row(static_cast<Eigen::Index>(joint)).cwiseAbs().dot(widths);
}

/// A joint's loop at inertias of its range, each evaluated once.
class LoopOfJoint {
 public:
  LoopOfJoint(const Spec& spec, std::size_t joint)
      : control_(*spec.model.control),
        joint_(joint),
        count_(count_of(spec, joint)),
        lasting_(lasting_error(spec, joint)),
        step_(largest_step(controller_of(control_.joints[joint], control_.sample_rate))) {}

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
  void set_cycle(LoopAtInertia& l, double inertia, double motion, double torque) {
    const LoopReading& reading = control_.joints[joint_].reading;
    l.cycle = limit_cycle(l.margins, motion, torque, step_, reading, count_, lasting_);
    // Between two counts the set point is at most half a count from the edge, on which the reading changes.
    l.cycle.ending_friction = (torque_norm_ + std::abs(control_.joints[joint_].kp)) * lasting_;
    if (reading.play > 0)
      l.cycle.play = play_cycle(loop_of(control_, joint_, inertia), reading.play, reading.behind_play);
  }

  const Control control_;
  std::size_t joint_;
  double count_, lasting_, step_, torque_norm_;
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

LoopReport loop_report(const Spec& spec, std::size_t joint, const Eigen::MatrixXd& configurations) {
  LoopReport r;
  r.joint = joint;
  LoopOfJoint loop(spec, joint);
  if (set_inertias(r, spec, configurations))
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

WallReport wall_report(const Spec& spec, const Wall& wall, const Eigen::MatrixXd& configurations) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  WallReport r{wall.name, {infinity, infinity, 0, 0}, infinity, infinity, {}};
  const Transmission& t = spec.model.transmission;
  const Eigen::MatrixXd coupling = t.coupling.dense();
  const Eigen::VectorXd widths = widths_at_rest(*spec.model.control, resolutions(t));
  for (Eigen::Index c = 0; c < configurations.cols(); ++c) {
    const Eigen::VectorXd q = configurations.col(c);
    const WallLimit limit =
        wall_limit(*spec.model.control, felt_by(spec.model.chain, wall, q), coupling, widths);
    r.sampling = std::min(r.sampling, limit.sampling);
    r.quantization = std::min(r.quantization, limit.quantization);
    if (r.at.size() > 0 && limit.stiffness() >= r.limit.stiffness()) continue;
    r.limit = limit;
    r.at = q;
  }
  return r;
}

/// The joint whose torque a requirement limits from above, with kp and kd; empty: none, or its spectrum is
/// not known without the errors' motion.
std::optional<std::size_t> limited_torque(const Spec& spec, const Requirement& r) {
  if (!r.limits_error() || r.at_least || r.filter < 0) return std::nullopt;
  const NamedFilter& f = spec.filters[static_cast<std::size_t>(r.filter)];
  const bool known = r.bound == Bound::worst_case ? !spec.model.along_motion
                                                  : r.bound == Bound::sigma && spec.model.sources.empty();
  if (!f.controller || !known || !(spec.model.control->joints[f.joints.front()].kd > 0)) return std::nullopt;
  return f.joints.front();
}

/// The largest kd at which the torque keeps a limit; 0 if none does.
///
/// ||kp + kd H||_1 h + |kp + kd H(1)| |m| and ||kp + kd H||_2 sigma are convex in kd, so that below the
/// largest one there is a single crossing.
double largest_kd(const Spec& spec, std::size_t joint, const Requirement& r) {
  const JointController& c = spec.model.control->joints[joint];
  const ResponseSums sums = response_sums(c.velocity_filter);
  const JointError error = joint_error(spec.model);
  const auto j = static_cast<Eigen::Index>(joint);
  const auto met = [&](double kd) {
    const double torque = r.bound == Bound::worst_case
                              ? sums.l1(c.kp, kd) * error.half_width[j] +
                                    std::abs(c.kp + kd * sums.dc) * std::abs(error.mean[j])
                              : sums.h2(c.kp, kd) * error.sigma[j];
    return torque <= r.limit;
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

/// ||kp + kd H||_1 of the joint's own controller, or of each pair of joints of an impedance at the tip:
/// errors of joint j in the torque of a joint.
Eigen::RowVectorXd torque_norms(const Spec& spec, std::size_t joint, const Eigen::VectorXd& q,
                                const Eigen::MatrixXd& moved, const std::vector<ResponseSums>& sums) {
  const Control& control = *spec.model.control;
  const auto row = static_cast<Eigen::Index>(joint);
  if (!control.tip)
    return moved.row(row).cwiseAbs() * sums[joint].l1(control.joints[joint].kp, control.joints[joint].kd);
  const Eigen::MatrixXd j = jacobian(spec.model.chain, q).topRows<3>();
  const Eigen::RowVectorXd k = j.col(row).transpose() * control.tip->stiffness.asDiagonal() * j * moved,
                           d = j.col(row).transpose() * control.tip->damping.asDiagonal() * j * moved;
  Eigen::RowVectorXd norms(moved.cols());
  for (Eigen::Index e = 0; e < norms.size(); ++e) norms[e] = control.tip->velocity_sums.l1(k[e], d[e]);
  return norms;
}

/// The torques due to errors within their half widths; means are left out.
std::vector<TorqueReport> torque_reports(const Spec& spec, const Eigen::MatrixXd& configurations) {
  const Control& control = *spec.model.control;
  const Transmission& t = spec.model.transmission;
  const auto& joints = spec.model.chain.independent;
  std::vector<IndependentError> errors = independent_errors(spec.model);
  std::erase_if(errors, [](const auto& e) { return e.where == IndependentError::Where::origin; });
  Eigen::MatrixXd moved(static_cast<Eigen::Index>(joints.size()), static_cast<Eigen::Index>(errors.size()));
  for (Eigen::Index e = 0; e < moved.cols(); ++e)
    moved.col(e) = moved_joints(t, errors[static_cast<std::size_t>(e)]);
  std::vector<ResponseSums> sums(joints.size());
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (control.joints[j].kd > 0) sums[j] = response_sums(control.joints[j].velocity_filter);
  std::vector<TorqueReport> all;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (!control.tip && !control.joints[j].acts()) continue;
    TorqueReport r{j, 0, {}, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(joints.size()))};
    const Eigen::Index count = control.tip ? configurations.cols() : 1;
    for (Eigen::Index c = 0; c < count; ++c) {
      const Eigen::RowVectorXd norms = torque_norms(spec, j, configurations.col(c), moved, sums);
      Eigen::VectorXd parts = Eigen::VectorXd::Zero(r.share.size());
      for (Eigen::Index e = 0; e < norms.size(); ++e) {
        const IndependentError& error = errors[static_cast<std::size_t>(e)];
        parts[static_cast<Eigen::Index>(error.owner)] += std::abs(norms[e]) * error.half_width;
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

std::vector<GainReport> gain_reports(const Spec& spec) {
  std::vector<GainReport> gains;
  for (const Requirement& r : spec.requirements) {
    const std::optional<std::size_t> joint = limited_torque(spec, r);
    if (!joint) continue;
    const GainReport gain{*joint, largest_kd(spec, *joint, r), r.quantity};
    const auto known =
        std::find_if(gains.begin(), gains.end(), [&](const GainReport& g) { return g.joint == *joint; });
    if (known == gains.end())
      gains.push_back(gain);
    else if (gain.kd < known->kd)
      *known = gain;
  }
  return gains;
}

}  // namespace

namespace {

/// Whether a requirement names a figure of the joint's loop.
bool is_required(const Spec& spec, std::size_t joint) {
  for (const ControlFigure& f : control_figures(*spec.model.control, spec.model.chain))
    if (f.kind != ControlFigure::Kind::wall_stiffness && f.index == joint &&
        std::any_of(spec.requirements.begin(), spec.requirements.end(),
                    [&](const Requirement& r) { return r.of_control && r.quantity == f.name; }))
      return true;
  return false;
}

/// Whether two joints have one loop, of equal gains, inertias and counts.
bool have_one_loop(const Spec& spec, std::size_t a, std::size_t b) {
  const std::vector<JointController>& all = spec.model.control->joints;
  return all[a].inertia && close_the_same(all[a], all[b]) && count_of(spec, a) == count_of(spec, b);
}

/// Joints whose readings are delayed or multiplied in a way that is not in the loops: those of a coupled
/// transmission, and at walls all that are multiplied. "" if there are none.
/// @param joint  of the loop; empty: of any
std::string uncounted_readings(const Spec& spec, std::optional<std::size_t> joint, bool of_walls) {
  std::string all;
  const Eigen::MatrixXd coupling = spec.model.transmission.coupling.dense();
  for (std::size_t j = 0; j < spec.model.control->joints.size(); ++j) {
    const LoopReading& r = spec.model.control->joints[j].reading;
    const auto at = static_cast<Eigen::Index>(j);
    const bool alone = (coupling.row(at).array() != 0).count() == 1 &&
                       (coupling.col(at).array() != 0).count() == 1,
               concerned = !joint || coupling(static_cast<Eigen::Index>(*joint), at) != 0;
    if (concerned && ((of_walls && r.factor != 1) || (!alone && (r.factor != 1 || r.delay != 0))))
      all += (all.empty() ? "" : ", ") + spec.model.chain.independent[j].name;
  }
  return all;
}

constexpr const char* about_uncounted =
    "delayed (latency) or multiplied (scale, decoding), which is not counted there";

}  // namespace

void refuse_changed_loops(const Spec& spec) {
  if (!spec.model.control) return;
  const std::vector<Signal> signals = all_signals(spec.model);
  const std::vector<ControlFigure> figures = control_figures(*spec.model.control, spec.model.chain);
  std::vector<Fault> faults;
  for (const Requirement& r : spec.requirements) {
    std::optional<std::size_t> joint;  // of the only loop that the figure depends on
    bool of_walls = false;
    for (const ControlFigure& f : figures)
      if (r.of_control && f.name == r.quantity) {
        of_walls = f.kind == ControlFigure::Kind::wall_stiffness;
        if (!of_walls) joint = f.index;
      }
    if (!r.of_control && !(r.limits_error() && is_closed(signals[r.signal]))) continue;
    if (const std::string joints = uncounted_readings(spec, joint, of_walls); !joints.empty())
      faults.push_back(
          {r.place, "requirements", "readings of " + joints + " are " + about_uncounted, quoted(r.quantity),
           "state a latency as control.delay, a factor in the gains; leave the effect out here"});
  }
  if (!faults.empty()) throw Error(faults);
}

ControlReport control_report(const Spec& spec, bool required_only) {
  ControlReport report;
  if (!spec.model.control) return report;
  const Control& control = *spec.model.control;
  report.gains = gain_reports(spec);
  const Eigen::MatrixXd configurations = first_configurations(spec);
  if (configurations.cols() == 0) return report;
  std::vector<std::size_t> joints, first;  // of each the place of the first joint with the same loop
  for (std::size_t j = 0; j < control.joints.size(); ++j) {
    if (!has_loop(control, spec.model.chain, j) || (required_only && !is_required(spec, j))) continue;
    const auto same = std::find_if(joints.begin(), joints.end(),
                                   [&](std::size_t other) { return have_one_loop(spec, other, j); });
    first.push_back(static_cast<std::size_t>(same - joints.begin()));
    joints.push_back(j);
  }
  if (!required_only) report.torques = torque_reports(spec, configurations);
  report.loops.resize(joints.size());
  parallel_for(joints.size(), 0, [&](std::size_t i) {
    if (first[i] == i) report.loops[i] = loop_report(spec, joints[i], configurations);
  });
  for (std::size_t i = 0; i < joints.size(); ++i) {
    report.loops[i] = report.loops[first[i]];
    report.loops[i].joint = joints[i];
  }
  if (!control.walls.empty() && missing_for_walls(control, spec.model.chain).empty())
    for (const Wall& wall : control.walls) report.walls.push_back(wall_report(spec, wall, configurations));
  return report;
}

bool any_of_control(const Spec& spec) {
  return std::any_of(spec.requirements.begin(), spec.requirements.end(),
                     [](const Requirement& r) { return r.of_control; });
}

double control_value(const Requirement& r, const Spec& spec, const ControlReport& report) {
  using Kind = ControlFigure::Kind;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const ControlFigure& f : control_figures(*spec.model.control, spec.model.chain)) {
    if (f.name != r.quantity) continue;
    if (f.kind == Kind::wall_stiffness) {
      if (f.index < report.walls.size()) {
        const double stiffness = report.walls[f.index].limit.stiffness();
        if (std::isfinite(stiffness)) return stiffness;
        throw Error({r.place, "requirements",
                     "no joint feels this wall: it is unbounded at all configurations, which meets any limit",
                     quoted(r.quantity), "turn its normal to where the joints move the tip"});
      }
      throw Error(
          {r.place, "requirements", "the stiffness of a wall needs damping and friction of all joints",
           quoted(r.quantity),
           "state " + missing_for_walls(*spec.model.control, spec.model.chain) + " in control.joints"});
    }
    if (f.kind == Kind::largest_kd) {
      for (const GainReport& gain : report.gains)
        if (gain.joint == f.index) return gain.kd;
      throw Error({r.place, "requirements", "the largest kd is that for a limit of the joint's torque",
                   quoted(r.quantity),
                   "require at_most of torque." + spec.model.chain.independent[f.index].name +
                       ".worst_case or, without accuracy and effects, .sigma"});
    }
    for (const LoopReport& loop : report.loops) {
      if (loop.joint != f.index) continue;
      if (!loop.stable) return f.kind == Kind::limit_cycle && !r.at_least ? infinity : unknown_figure;
      return f.kind == Kind::gain_margin    ? loop.margins.gain
             : f.kind == Kind::phase_margin ? loop.margins.phase.value_or(infinity)
             : f.kind == Kind::bandwidth    ? loop.margins.bandwidth.value_or(infinity)
                                            : loop.cycle.bound;
    }
  }
  throw Error({r.place, "requirements", "the figure has no value", quoted(r.quantity), "see `qerr analyze`"});
}

std::vector<std::string> control_warnings(const Spec& spec, const ControlReport& report) {
  std::vector<std::string> warnings;
  if (!spec.model.control) return warnings;
  const Control& control = *spec.model.control;
  const Chain& chain = spec.model.chain;
  std::string without;
  for (std::size_t j = 0; j < control.joints.size(); ++j)
    if (control.joints[j].acts() && !has_loop(control, chain, j))
      without += (without.empty() ? "" : ", ") + chain.independent[j].name;
  if (!without.empty())
    warnings.push_back("control: the loop of " + without +
                       " is not closed: its inertia is not known; state 'inertia:'" +
                       (spec.model.tips ? ", as the masses beyond several tips are not added up"
                                        : ", or give the URDF's links their masses"));
  if (const std::string joints = uncounted_readings(spec, {}, !control.walls.empty()); !joints.empty())
    warnings.push_back("control: in loops of coupled joints" +
                       std::string(control.walls.empty() ? "" : " and walls") + " readings of " + joints +
                       " are " + about_uncounted);
  for (const LoopReport& l : report.loops)
    if (!l.stable)
      warnings.push_back(
          "control: the loop of joint '" + chain.independent[l.joint].name +
          "' is unstable at an inertia of " +
          readable(l.unstable_inertia, chain.independent[l.joint].prismatic() ? "kg" : "kg m^2") +
          ", its errors are unbounded; " +
          (l.margins.gain > 0 ? "it is stable below " + significant(l.margins.gain, 4) + " times its gains"
                              : "no smaller gain makes it stable"));
  const std::string missing = missing_for_walls(control, chain);
  if (!control.walls.empty() && !missing.empty())
    warnings.push_back("walls: no stiffness is given; state " + missing + " in control.joints");
  return warnings;
}

namespace {

std::string degrees(const std::optional<double>& angle) {
  return angle ? significant(*angle * 180 / std::numbers::pi, 3) + " deg" : "-";
}

std::string hertz(const std::optional<double>& f) { return f ? readable(*f, "Hz") : "-"; }

ControlTable loop_table(const Spec& spec, const ControlReport& report) {
  std::vector<std::vector<std::string>> rows{{"", "inertia", "gain margin", "phase margin", "bandwidth",
                                              "limit cycle at most", "predicted on a count",
                                              "predicted on an edge", "torque step"}};
  for (const LoopReport& l : report.loops) {
    const IndependentJoint& joint = spec.model.chain.independent[l.joint];
    const std::string unit = joint.prismatic() ? "m" : "rad", torque = joint.prismatic() ? "N" : "N m",
                      mass = joint.prismatic() ? "kg" : "kg m^2";
    std::string inertia = significant(l.least_inertia, 3);
    if (l.largest_inertia > l.least_inertia * 1.001) inertia += " .. " + significant(l.largest_inertia, 3);
    if (!l.stable) {
      rows.push_back(
          {shown(joint.name), inertia + ' ' + mass, "unstable", "-", "-", "unbounded", "-", "-", "-"});
      continue;
    }
    const LimitCycle& c = l.cycle;
    rows.push_back({shown(joint.name), inertia + ' ' + mass,
                    std::isinf(l.margins.gain) ? "inf" : significant(l.margins.gain, 4),
                    degrees(l.margins.phase), hertz(l.margins.bandwidth), readable(c.bound, unit),
                    c.on_count ? "yes" : "no",
                    c.on_edge ? readable(c.edge_amplitude, unit) + " at " + hertz(c.frequency) : "no",
                    readable(c.torque_step, torque)});
  }
  const bool sampled = std::any_of(report.loops.begin(), report.loops.end(),
                                   [](const LoopReport& l) { return l.largest_inertia > l.least_inertia; });
  std::string of_play, of_friction;
  for (const LoopReport& l : report.loops) {
    if (!l.stable) continue;
    const IndependentJoint& joint = spec.model.chain.independent[l.joint];
    const auto& friction = spec.model.control->joints[l.joint].friction;
    if (l.cycle.on_edge)
      of_friction += (of_friction.empty() ? "" : ", ") + shown(joint.name) + ' ' +
                     readable(l.cycle.ending_friction, joint.prismatic() ? "N" : "N m") +
                     (!friction                             ? ""
                      : *friction > l.cycle.ending_friction ? " (less than stated)"
                                                            : " (more than stated)");
    if (l.cycle.play)
      of_play += (of_play.empty() ? "; play is predicted to keep alive: " : ", ") + shown(joint.name) + ' ' +
                 readable(l.cycle.play->amplitude, joint.prismatic() ? "m" : "rad") + " at " +
                 hertz(l.cycle.play->frequency);
  }
  return {
      sampled ? "Loops, at the worst inertia between these ends" : "Loops",
      std::move(rows),
      {std::string("limit cycle at most: ") +
       (sampled ? "whatever the motion; proven at each inertia, the worst of which is searched"
                : "proven, whatever the motion") +
       "; predicted: by the describing function of rounding, a first harmonic: short pulses may keep "
       "alive what it does not predict" +
       (of_friction.empty() ? "" : "; Coulomb friction that ends one between two counts: " + of_friction) +
       of_play}};
}

ControlTable wall_table(const Spec& spec, const ControlReport& report) {
  std::vector<std::vector<std::string>> rows{
      {"", "passive stiffness", "decided by", "joint", "limit of the rate", "limit of the counts"}};
  std::string places;
  for (const WallReport& w : report.walls) {
    if (std::isinf(w.limit.stiffness())) {
      rows.push_back({shown(w.name), "felt by no joint", "-", "-", "-", "-"});
      continue;
    }
    rows.push_back({shown(w.name), readable(w.limit.stiffness(), "N/m"),
                    w.limit.by_quantization() ? "counts, friction" : "rate, damping",
                    shown(spec.model.chain.independent[w.limit.joint()].name), readable(w.sampling, "N/m"),
                    readable(w.quantization, "N/m")});
    places += (places.empty() ? "least at " : "; ") + shown(w.name) + ": ";
    for (Eigen::Index j = 0; j < w.at.size(); ++j)
      places += (j ? ", " : "") + shown(spec.model.chain.independent[static_cast<std::size_t>(j)].name) +
                ' ' + significant(w.at[j], 4);
  }
  return {"Virtual walls: the least stiffness over the configurations that stays passive",
          std::move(rows),
          {places,
           "a finer encoder helps up to the limit of the rate, a faster loop or a shorter delay up to that "
           "of the counts"}};
}

std::string gain_line(const Spec& spec, const ControlReport& report) {
  std::string text;
  for (const GainReport& g : report.gains) {
    const IndependentJoint& joint = spec.model.chain.independent[g.joint];
    text += (text.empty() ? "" : "; ") + shown(joint.name) + ' ' +
            (g.kd > 0 ? significant(g.kd, 4) + (joint.prismatic() ? " N s/m" : " N m s/rad") : "none") +
            " (" + g.quantity + ')';
  }
  return text.empty() ? "" : "largest kd that meets the requirements, loop open: " + text;
}

ControlTable torque_table(const Spec& spec, const ControlReport& report) {
  const auto& joints = spec.model.chain.independent;
  const bool limited = std::any_of(report.torques.begin(), report.torques.end(),
                                   [](const TorqueReport& t) { return t.relative.has_value(); });
  std::vector<std::vector<std::string>> rows{{"", "worst case"}};
  if (limited) rows[0].emplace_back("of the effort limit");
  rows[0].emplace_back("encoders' parts of it");
  for (const TorqueReport& t : report.torques) {
    std::string parts;
    for (Eigen::Index e = 0; e < t.share.size(); ++e)
      if (constexpr double shown_from = 0.005; t.share[e] >= shown_from)
        parts += (parts.empty() ? "" : ", ") + shown(joints[static_cast<std::size_t>(e)].name) + ' ' +
                 percent(t.share[e]);
    rows.push_back(
        {shown(joints[t.joint].name), readable(t.worst_case, joints[t.joint].prismatic() ? "N" : "N m")});
    if (limited) rows.back().push_back(t.relative ? significant(100 * *t.relative, 3) + " %" : "-");
    rows.back().push_back(parts);
  }
  return {"Torques due to errors, the loops open", std::move(rows), {}};
}

}  // namespace

std::vector<ControlTable> control_tables(const Spec& spec, const ControlReport& report) {
  std::vector<ControlTable> all;
  if (!report.torques.empty()) all.push_back(torque_table(spec, report));
  if (!report.loops.empty()) all.push_back(loop_table(spec, report));
  if (const std::string gains = gain_line(spec, report); !gains.empty()) {
    if (all.empty()) all.emplace_back();
    all.back().notes.push_back(gains);
  }
  if (!report.walls.empty()) all.push_back(wall_table(spec, report));
  return all;
}

std::string control_text(const Spec& spec, const ControlReport& report, const Style& style) {
  std::string out;
  for (const ControlTable& table : control_tables(spec, report)) {
    if (!table.rows.empty()) out += heading(table.title, style) + fitted_table(table.rows, style.width);
    for (const std::string& note : table.notes) out += wrapped(note, style.width, "  ");
  }
  return out;
}

}  // namespace qerr
