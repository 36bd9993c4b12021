#include <algorithm>
#include <memory>

#include "control/loop.hpp"
#include "control/loop_response.hpp"
#include "core/lists.hpp"
#include "core/text.hpp"
#include "effect/action_path.hpp"
#include "input/joint_entries.hpp"
#include "input/read_sections.hpp"
#include "kinematics/inverse_dynamics.hpp"

/// Reads the sections `control` and `walls` of a spec.
namespace qerr {

namespace {

constexpr double longest_delay = 64;  // samples: each is an order of the loop

constexpr std::string_view of_controllers = "torque.";  ///< before a joint's name: its filter

/// A dimension at a revolute joint or, per metre, at a prismatic one.
Dimension at_joint(const IndependentJoint& joint, const Dimension& revolute, const Dimension& prismatic) {
  return joint.prismatic() ? prismatic : revolute;
}

Dimension stiffness(const IndependentJoint& j) { return at_joint(j, {1, -1, 0, 1}, {-1, 0, 0, 1}); }

std::optional<double> read_gain(const Object& o, std::string_view key, const Dimension& d,
                                bool positive = false) {
  if (!o.has(key)) return std::nullopt;
  return read_number(o.at(key), {.name = key, .dimension = d, .least = 0, .open_below = positive});
}

/// The filter that the key `velocity` names. @param beside  the key that needs it
const NamedFilter& velocity_of(const Object& o, const Spec& spec, std::string_view beside) {
  std::vector<std::string> known;
  for (const NamedFilter& f : spec.filters)
    if (f.filter.derivative == 1) known.push_back(f.name);
  if (!o.has("velocity"))
    o.at(beside).refuse("needs the filter that estimates the velocity",
                        "add 'velocity: ...' (" + did_you_mean("", known) + ")");
  const std::string name = *o.text("velocity");
  const NamedFilter* const named = find_named(spec.filters, name);
  if (!named || named->filter.derivative != 1)
    o.at("velocity")
        .refuse(named ? "must be a filter with derivative 1" : "no such filter", did_you_mean(name, known));
  return *named;
}

JointController read_controller(const Field& f, const IndependentJoint& joint, const Spec& spec) {
  const Object o(f, spec_format::controller);
  const Dimension kp = stiffness(joint);
  const Dimension damping{kp.metre, kp.radian, 1, 1};
  JointController c;
  c.kp = read_gain(o, "kp", kp).value_or(0);
  c.kd = read_gain(o, "kd", damping).value_or(0);
  if (c.kd > 0) {
    const NamedFilter& velocity = velocity_of(o, spec, "kd");
    c.velocity = velocity.name;
    c.velocity_filter = velocity.filter;
  } else if (o.has("velocity") && !o.has("kd")) {
    o.at("velocity").refuse("is used with kd only", "add 'kd: ...', or remove velocity");
  }
  c.inertia = read_gain(o, "inertia", at_joint(joint, {1, 0, 2, 1}, {-1, 0, 2, 1}), true);
  c.damping = read_gain(o, "damping", damping);
  c.friction = read_gain(o, "friction", at_joint(joint, dimension::torque, {0, 0, 0, 1}));
  return c;
}

Eigen::Vector3d read_axes(const Field& f, const Dimension& d, const std::string& example) {
  const std::vector<Field> items = read_list(f, example);
  if (items.size() != 3) f.refuse("must be three numbers, along x, y and z", "write " + example);
  Eigen::Vector3d axes;
  for (Eigen::Index i = 0; i < 3; ++i) axes[i] = read_number(items[i], {.name = "axis", .dimension = d});
  return axes;
}

TipImpedance read_impedance(const Field& f, const Spec& spec) {
  const Object o(f, spec_format::tip_impedance);
  TipImpedance t;
  t.stiffness = read_axes(o.at("stiffness"), {-1, 0, 0, 1}, "[2 kN/m, 2 kN/m, 2 kN/m]");
  if (o.has("damping"))
    t.damping = read_axes(o.at("damping"), {-1, 0, 1, 1}, "[20 N s/m, 20 N s/m, 20 N s/m]");
  for (const auto& [key, axes] : {std::pair{"stiffness", &t.stiffness}, std::pair{"damping", &t.damping}})
    if (o.has(key) && !(axes->minCoeff() >= 0 && axes->maxCoeff() > 0))
      o.at(key).refuse("must be at least 0, and one of them above", "give positive numbers");
  if (t.damping.isZero(0)) {
    if (o.has("velocity"))
      o.at("velocity").refuse("is used with damping only", "add 'damping: ...', or remove velocity");
    return t;
  }
  const NamedFilter& velocity = velocity_of(o, spec, "damping");
  t.velocity = velocity.name;
  t.velocity_sums = response_sums(velocity.filter);
  t.sample_rate = velocity.filter.sample_rate;
  return t;
}

/// The rate of the loops: stated, or that of all velocity filters.
double rate_of(const Object& o, const Control& control) {
  std::optional<double> rate = o.number("sample_rate");
  const auto match = [&](const std::string& velocity, double its_rate) {
    if (velocity.empty()) return;
    if (!rate) rate = its_rate;
    if (*rate != its_rate)
      o.self().refuse("the loops have one sample rate, and filter '" + velocity + "' has " +
                          shortest(its_rate) + " Hz, not " + shortest(*rate),
                      "give sample_rate that of the filter");
  };
  for (const JointController& c : control.joints) match(c.velocity, c.velocity_filter.sample_rate);
  if (control.tip) match(control.tip->velocity, control.tip->sample_rate);
  if (!rate) o.self().refuse("missing key 'sample_rate'", "add 'sample_rate: ...', such as 1 kHz");
  return *rate;
}

/// F of each joint's controller, as a filter of its coordinate.
void add_controllers(const Field& f, const Control& control, Spec& spec) {
  for (std::size_t j = 0; j < control.joints.size(); ++j) {
    const IndependentJoint& joint = spec.model.chain.independent[j];
    if (!control.joints[j].acts()) continue;
    const std::string name = std::string(of_controllers) + joint.name;
    for (const NamedFilter& other : spec.filters)
      if (other.name == name || other.name + '.' == of_controllers)
        f.refuse("filter '" + other.name + "' has the name of a controller's torque",
                 "give the filter another name");
    Filter filter = controller_of(control.joints[j], control.sample_rate);
    filter.unit = stiffness(joint);
    try {
      spec.filters.push_back({name, filter, checked_norms(filter), {}, {j}, true});
    } catch (const Error& e) {
      f.refuse("controller of joint '" + joint.name + "': " + e.faults().front().rule,
               e.faults().front().remedy);
    }
  }
}

/// A loop needs an inertia: one is stated, or the URDF has masses that the joint moves.
void check_inertias(const Field& f, const Control& control, const Spec& spec) {
  const Chain& chain = spec.model.chain;
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(std::ssize(chain.independent));
  if (!has_masses(chain)) return;
  for (std::size_t j = 0; j < control.joints.size(); ++j)
    if (control.joints[j].acts() && !control.joints[j].inertia && !(inertia_at(chain, j, zero) > 0))
      f.refuse("joint '" + chain.independent[j].name + "' moves no mass of the URDF",
               "state its inertia: " + chain.independent[j].name + ": {..., inertia: 0.1 kg m^2}");
}

void read_controllers(const Field& f, const RobotModel& robot, Spec& spec, Control& control) {
  const Chain& chain = spec.model.chain;
  EntryFaults of_entries;
  Faults of_patterns;
  const std::vector<JointEntry> entries = joint_entries(f, robot, spec, of_patterns);
  of_patterns.raise();
  for (std::size_t j = 0; j < entries.size(); ++j)
    if (entries[j].given())
      of_entries.guard(chain.independent[j], entries[j].holding(), [&] {
        control.joints[j] = read_controller(entries[j].holding(), chain.independent[j], spec);
      });
  of_entries.raise();
}

}  // namespace

void read_control(const Field& f, const RobotModel& robot, Spec& spec) {
  const Object o(f, spec_format::control);
  const Chain& chain = spec.model.chain;
  Control control;
  control.joints.resize(chain.independent.size());
  if (!o.has("joints") && !o.has("tip"))
    o.self().refuse("has no controller",
                    "add joints: {'*': {kp: 400 N m/rad, kd: 5 N m s/rad, velocity: ...}}");
  if (o.has("joints")) read_controllers(o.at("joints"), robot, spec, control);
  const auto acts = [](const JointController& c) { return c.acts(); };
  if (o.has("tip")) {
    if (spec.model.tips)
      o.at("tip").refuse("is an impedance of one tip, and the robot has several",
                         "give the spec one 'robot.tip'");
    if (std::ranges::any_of(control.joints, acts))
      o.at("tip").refuse("torques have one controller, at the joints or at the tip",
                         "leave out kp and kd of the joints, or the tip");
    control.tip = read_impedance(o.at("tip"), spec);
  }
  control.sample_rate = rate_of(o, control);
  control.delay = o.number("delay").value_or(1 / control.sample_rate);
  if (!(control.delay * control.sample_rate <= longest_delay))
    o.at("delay").refuse("is longer than 64 samples", "give the time from reading to torque, such as 1 ms");
  check_inertias(f, control, spec);
  add_controllers(f, control, spec);
  spec.model.control = std::make_shared<const Control>(with_stated_loops(std::move(control)));
}

std::shared_ptr<const Control> with_velocity_filters(const std::shared_ptr<const Control>& control,
                                                     const std::vector<NamedFilter>& filters) {
  if (!control) return nullptr;
  Control changed = *control;
  for (JointController& c : changed.joints)
    for (const NamedFilter& f : filters)
      if (f.name == c.velocity && !c.velocity.empty()) c.velocity_filter = f.filter;
  for (const NamedFilter& f : filters)
    if (changed.tip && f.name == changed.tip->velocity) changed.tip->velocity_sums = response_sums(f.filter);
  return std::make_shared<const Control>(with_stated_loops(std::move(changed)));
}

void update_controllers(const Control& control, std::vector<NamedFilter>& filters) {
  for (NamedFilter& f : filters) {
    if (!f.controller) continue;
    const auto unit = f.filter.unit;
    f.filter = controller_of(control.joints[f.joints.front()], control.sample_rate);
    f.filter.unit = unit;
    f.norms = checked_norms(f.filter);
  }
}

void read_walls(const Field& f, Spec& spec, Faults& faults) {
  if (!spec.model.control)
    f.refuse("walls need the rate, damping and friction of `control`",
             "add control: {sample_rate: 1 kHz, joints: {'*': {damping: ..., friction: ...}}}");
  if (spec.model.tips)
    f.refuse("a wall is felt by one tip, and the robot has several", "give the spec one 'robot.tip'");
  Control control = *spec.model.control;
  for (const auto& [key, field] : read_map(f))
    faults.guard([&, &key = key, &field = field] {
      const Object o(field, spec_format::wall);
      const Eigen::Vector3d normal = read_axes(o.at("normal"), dimension::none, "[0, 0, 1]");
      if (!(normal.norm() > 0)) o.at("normal").refuse("must not be zero", "write normal: [0, 0, 1]");
      control.walls.push_back({key.name, normal.normalized()});
    });
  spec.model.control = std::make_shared<const Control>(std::move(control));
}

void add_loop_readings(const Field& f, Spec& spec) {
  std::vector<Fault> faults;
  Control control = *spec.model.control;
  const Chain& chain = spec.model.chain;
  for (std::size_t j = 0; j < control.joints.size(); ++j) {
    const std::string& name = chain.independent[j].name;
    LoopReading& reading = control.joints[j].reading = {};
    for (const Effect& e : spec.effects)
      if (e.joint == name) add_to_reading(e, spec.model.transmission.encoders[j], reading);
    if (!control.joints[j].acts()) continue;
    const auto fault = [&](const char* rule, const std::string& found, const char* remedy) {
      faults.push_back({f.node->place, f.path, "the loop of joint '" + name + "' " + rule, found, remedy});
    };
    const double delay = control.samples_of_delay(j);
    if (reading.factor == 0)
      fault("reads nothing: its effects multiply the reading by 0", "", "give the scale another value");
    if (delay < 0)
      fault("would read the future: its reading is early by more than control.delay",
            shortest(delay) + " samples", "raise control.delay, or make the latency positive");
    if (delay > longest_delay)
      fault("is delayed by more than 64 samples, by control.delay and latency", shortest(delay) + " samples",
            "make the latency shorter, or the loop slower");
  }
  if (!faults.empty()) throw Error(faults);
  spec.model.control = std::make_shared<const Control>(with_stated_loops(std::move(control)));
}

void add_signals_of_joints(Spec& spec) {
  for (const SignalKind& kind : signal_kinds())
    for (const Signal& s : find_signals(spec.model, kind.group)) {
      const bool of_filter = kind.joints && std::ranges::any_of(spec.filters, [&](const NamedFilter& f) {
                               return !f.joints.empty() && is_filtered(f, s);
                             });
      if (of_filter || kind.norms) add_signal(s, spec.model);
    }
}

}  // namespace qerr
