#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/joint_entries.hpp"
#include "input/read_sections.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "qerr/encoder/encoder.hpp"

/// Reads the sections `motion` and `effects` of a spec.
namespace qerr {

namespace {

Dimension over_time(Dimension d, int power) {
  d.second = -power;
  return d;
}

std::vector<Move> read_moves(const Object& o, Dimension unit) {
  for (const std::string_view key : {"sines", "velocity"})
    if (o.has(key))
      o.at(key).refuse("cannot be combined with moves", "keep the moves, or the sines and velocity");
  std::vector<Move> moves;
  for (const Field& item :
       read_list(o.at("moves"), "[{to: 30 deg, velocity: 1 rad/s, acceleration: 5 rad/s^2}]")) {
    const Object move(item, spec_format::move);
    moves.push_back({*move.number("to", unit), *move.number("velocity", over_time(unit, 1)),
                     *move.number("acceleration", over_time(unit, 2)),
                     move.number("jerk", over_time(unit, 3)).value_or(0), *move.number("dwell")});
  }
  if (moves.empty()) o.at("moves").refuse("the list is empty", "give at least one move");
  return moves;
}

JointMotion read_joint_motion(const Field& f, const IndependentJoint& joint,
                              std::vector<std::string>& warnings) {
  const Object o(f, spec_format::joint_motion);
  const Dimension unit = coordinate_dimension(joint);
  JointMotion motion;
  motion.center = *o.number("center", unit);
  if (o.has("center") && !joint.prismatic()) warn_of_degrees(o.at("center"), 4, warnings);
  motion.velocity = *o.number("velocity", over_time(unit, 1));
  if (o.has("moves")) motion.moves = read_moves(o, unit);
  if (!o.has("sines")) return motion;
  for (const Field& item : read_list(o.at("sines"), "[{amplitude: 10 deg, frequency: 1 Hz}]")) {
    const Object sine(item, spec_format::sine);
    motion.sines.push_back(
        {*sine.number("amplitude", unit), *sine.number("frequency"), *sine.number("phase")});
    if (sine.has("phase")) warn_of_degrees(sine.at("phase"), 1, warnings);
  }
  return motion;
}

const EffectKind& effect_kind_of(const Field& f) {
  if (f.node->type != Node::Type::mapping) f.refuse("must be a mapping", "write {type: ..., joint: ...}");
  const Node* type = f.node->find("type");
  if (!type) f.refuse_missing("type", "add 'type: ...'; see `qerr list effects`");
  const EffectKind* statement = find_effect_kind(type->text);
  const auto& kinds = effect_kinds();
  if (statement && !find_named(kinds, type->text))
    Field{type, f.path_of("type")}.refuse(
        "is not an effect on the signal of a joint but a cause that `qerr diagnose` may report: " +
            std::string(statement->summary),
        std::string(statement->spec_remedy));
  return read_member(f, "type", kinds, "no such effect");
}

/// Effects within a line need the signals of the encoder, which not every encoder has.
void check_encoder(const Object& o, const Effect& effect, std::size_t joint, Spec& spec) {
  const auto& need = effect_kind(effect.type).encoder_need;
  if (!need) return;
  if (joint >= spec.encoder_figures.size() || spec.encoder_figures[joint].kind.empty()) return;  // faulty
  const EncoderKind& kind = encoder_kind(spec.encoder_figures[joint].kind);
  const double counts = spec.model.transmission.encoders[joint].counts_per_period;
  const std::string what = "the encoder of '" + effect.joint + "' counts " + shortest(counts) +
                           (counts == 1 ? " time" : " times") + " a period: ";
  if (counts < need->least || counts > need->most)
    o.at("type").refuse(what + std::string(need->why), std::string(need->remedy));
  if (need->period_must_be_given && !kind.period_remedy.empty())
    spec.warnings.push_back(o.self().path + ": the signal period of the encoder of '" + effect.joint +
                            "' is not stated; four counts are assumed. To state it, " +
                            std::string(kind.period_remedy));
}

/// The effect on one joint. Rows are written for revolute joints.
Effect effect_on(const Object& o, const EffectKind& kind, const std::vector<Parameter>& format,
                 std::size_t index, Spec& spec) {
  const IndependentJoint& of = spec.model.chain.independent[index];
  std::vector<Parameter> rows = format;
  for (Parameter& row : rows) row.dimension = dimension_at(row, of.prismatic());
  const Object typed(o.self(), rows);
  Effect effect{std::string(kind.name), of.name, {}, {}};
  effect.numbers = typed.numbers(kind.parameters, coordinate_dimension(of));
  effect.choices = typed.choices(kind.parameters);
  warn_of_bare_numbers(o.self(), rows, coordinate_dimension(of), spec.warnings);
  check_encoder(o, effect, index, spec);
  return effect;
}

using NamedEffects = std::set<std::pair<std::string, std::string>>;

/// Type and joint of the entries that name their joint, which beat patterns.
NamedEffects named_effects(const std::vector<Field>& entries) {
  NamedEffects named;
  for (const Field& entry : entries) {
    const Node* const type = entry.node->find("type");
    const Node* const joint = entry.node->find("joint");
    if (type && joint && joint->text.find_first_of("*?[") == std::string::npos)
      named.emplace(type->text, joint->text);
  }
  return named;
}

/// An entry of `effects`: an effect for each joint that its `joint` names, or whose pattern it fits and that
/// no entry of the same type names.
void read_effect(const Field& f, const NamedEffects& named, const RobotModel& robot, Spec& spec) {
  const EffectKind& kind = effect_kind_of(f);
  std::vector<Parameter> format = spec_format::effect;
  format.insert(format.end(), kind.parameters.begin(), kind.parameters.end());
  const Object o(f, format);
  if (spec.model.tips && (kind.stage == Stage::kinematics || kind.need == Need::effort))
    o.at("type").refuse("belongs to one chain, and the robot has several tips",
                        "give the spec one 'robot.tip', or leave the effect out");
  for (const Parameter& row : kind.parameters)
    if (row.dimension == dimension::angle && o.has(row.name))
      warn_of_degrees(o.at(row.name), 1, spec.warnings);
  if (o.at("joint").node->type != Node::Type::scalar)
    o.at("joint").refuse("must be one joint or a pattern of joints",
                         "write an entry for each joint, or a pattern such as 'joint[12]'");
  EntryFaults of_joints;
  for (const std::size_t index : find_joints(robot, spec.model.chain, *o.text("joint"),
                                             o.at("joint").node->place, o.at("joint").path)) {
    const std::string& name = spec.model.chain.independent[index].name;
    if (*o.text("joint") != name && named.contains({std::string(kind.name), name})) continue;
    of_joints.guard(spec.model.chain.independent[index], f,
                    [&] { spec.effects.push_back(effect_on(o, kind, format, index, spec)); });
  }
  of_joints.raise();
}

/// Whether the motion can exceed the limits: a bound on its range by the sums of amplitudes, without
/// sampling.
bool may_exceed(const JointMotion& m, double duration, const Limits& limits) {
  double amplitude = 0;
  for (const Sine& sine : m.sines) amplitude += sine.amplitude;
  double low = std::min(m.center, m.center + m.velocity * duration) - amplitude;
  double high = std::max(m.center, m.center + m.velocity * duration) + amplitude;
  for (const Move& move : m.moves) {
    low = std::min(low, move.to);
    high = std::max(high, move.to);
  }
  return !inside(low, limits) || !inside(high, limits);
}

/// @param place  of a joint's entry, or of the motion
void check_limits(const Spec& spec, const Motion& motion, const std::vector<Place>& places) {
  const auto& joints = spec.model.chain.independent;
  const auto is_candidate = [&](std::size_t i) {
    return joints[i].limits && joints[i].type != JointType::continuous &&
           (motion.joints.empty() || may_exceed(motion.joints[i], motion.duration, *joints[i].limits));
  };
  Eigen::MatrixX2d range;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (!is_candidate(i)) continue;
    if (range.rows() == 0) range = extent(motion);
    if (inside(range(i, 0), *joints[i].limits) && inside(range(i, 1), *joints[i].limits)) continue;
    throw Error(places[i], "motion.joints." + joints[i].name,
                "the motion exceeds the limits of the joint " + text_of(*joints[i].limits, joints[i]),
                "it spans " + text_of({range(i, 0), range(i, 1)}, joints[i]),
                "shift its center or reduce its amplitude; degrees need their unit; a joint that is not "
                "listed stays at 0");
  }
}

/// Efforts that are no torques or forces, on a robot whose masses tell its loads: a compliance is per torque.
void leave_out_currents(const std::string& path, Spec& spec, std::vector<RecordedSignal>& efforts) {
  for (std::size_t i = 0; i < efforts.size(); ++i) {
    const IndependentJoint& joint = spec.model.chain.independent[i];
    const std::string unit = joint.effort_unit();
    if (efforts[i].values.size() == 0 || efforts[i].unit == unit) continue;
    spec.warnings.push_back(path + ": '" + joint.name + ".effort' is in " + efforts[i].unit + ", not in " +
                            unit + ": the load is that of the URDF's masses");
    efforts[i] = {};
  }
}

void read_table(const Field& f, const std::string& path, Spec& spec, Motion& motion) {
  const JointTable table = read_joint_table(path, spec, TimeColumn::required, spec.warnings);
  motion.file = path;
  motion.table = {table.time, table.positions, table.efforts, table.temperatures};
  if (has_masses(spec.model.chain)) leave_out_currents(path, spec, motion.table.efforts);
  if (table.time.size() < 2)
    throw Error({path, table.lines.front(), 1}, "time", "a motion must have at least two rows", "one row",
                "");
  const double length = table.time.back() - table.time.front();
  const double step = length / static_cast<double>(table.time.size() - 1);
  // The last row is a sample as well: the motion ends one sample period after it.
  if (motion.sample_rate == 0) {
    for (std::size_t i = 1; i < table.time.size(); ++i)
      if (std::abs(table.time[i] - table.time[i - 1] - step) > 1e-3 * step)
        throw Error(f.node->place, f.path + ".sample_rate",
                    "the times of the file are not equidistant: they define no sample rate",
                    "line " + std::to_string(table.lines[i]), "add 'sample_rate: ...' of the controller");
    motion.sample_rate = 1 / step;
  }
  const double available = length + 1 / motion.sample_rate;
  if (motion.duration > available * (1 + 1e-9))
    throw Error(f.node->place, f.path + ".duration", "the motion is longer than its file",
                shortest(motion.duration) + " s of " + shortest(length) + " s", "leave the duration out");
  if (motion.duration == 0) motion.duration = available;
}

}  // namespace

void read_motion(const Field& f, const std::string& folder, const RobotModel& robot, Spec& spec,
                 Faults& faults) {
  const Object o(f, spec_format::motion);
  Motion motion;
  motion.sample_rate = o.number("sample_rate").value_or(0);
  motion.duration = o.number("duration").value_or(0);
  motion.settling = o.number("settling");
  if (o.has("file") == o.has("joints"))
    f.refuse(o.has("file") ? "the motion must be given by a file or by joints, not by both"
                           : "the motion has neither joints nor a file",
             "give one of joints and file");
  std::vector<Place> places(spec.model.chain.independent.size(), f.node->place);
  if (const auto file = o.text("file")) {
    read_named_file(o.at("file"), (std::filesystem::path(folder) / *file).string(),
                    [&](const std::string& path) { read_table(f, path, spec, motion); });
  } else {
    for (const std::string key : {"sample_rate", "duration"})
      if (!o.has(key)) f.refuse_missing(key, "add '" + key + ": ...'");
    motion.joints.resize(places.size());
    bool valid = true;
    for (const auto& entry : read_map(o.at("joints"))) {
      if (off_chain(robot, spec.model.chain, entry.first.name)) {
        spec.warnings.push_back(entry.second.path + " is not used: the joint is not between base and tip");
        continue;
      }
      valid &= faults.guard([&] {
        const std::size_t i =
            find_joint(robot, spec.model.chain, entry.first.name, entry.first.place, entry.second.path);
        places[i] = entry.first.place;
        motion.joints[i] = read_joint_motion(entry.second, spec.model.chain.independent[i], spec.warnings);
      });
    }
    if (!valid) return;
  }
  constexpr double most_samples = 1e15;
  if (!(motion.duration * motion.sample_rate <= most_samples))
    f.refuse("the motion has too many samples",
             "at most " + shortest(most_samples) + ": shorten the duration or lower the rate");
  if (motion.settling.value_or(0) >= motion.duration)
    o.at("settling")
        .refuse("settling must be shorter than the motion",
                "give less than the duration of " + shortest(motion.duration) + " s");
  check_limits(spec, motion, places);
  spec.motion = motion;
}

void read_effects(const Field& f, const RobotModel& robot, Spec& spec, Faults& faults) {
  const std::vector<Field> entries = read_list(f, "a list: - {type: ..., joint: ...}");
  const NamedEffects named = named_effects(entries);
  for (const Field& entry : entries) faults.guard([&] { read_effect(entry, named, robot, spec); });
}

}  // namespace qerr
