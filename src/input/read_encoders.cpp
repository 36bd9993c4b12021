#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/solve.hpp"
#include "core/suggest.hpp"
#include "input/read_sections.hpp"
#include "qerr/encoder/encoder_kinds.hpp"

namespace qerr {

namespace {

/// Some vendors count lines in `cpr` and `ppr`, others counts: a factor of 4.
void refuse_ambiguous_keys(const Field& f) {
  for (const auto& [key, value] : read_map(f))
    for (const EncoderKind& kind : encoder_kinds())
      for (const std::string& ambiguous : words_of(kind.ambiguous_keys))
        if (key.name == ambiguous)
          throw Error(
              {key.place, value.path,
               "'" + key.name + "' is ambiguous: vendors use it for lines and for counts, 4 times as many",
               "'" + key.name + "'", std::string(kind.ambiguous_remedy)});
}

/// The first kind that is stated at the joint, or at the encoder's shaft.
const EncoderKind& first_kind(bool at_joint) {
  const auto& kinds = encoder_kinds();
  return *std::find_if(kinds.begin(), kinds.end(), [&](const EncoderKind& kind) {
    return (kind.resolution_at_joint != nullptr) == at_joint;
  });
}

std::string list_of_kinds() {
  std::string text;
  for (const EncoderKind& kind : encoder_kinds()) text += (text.empty() ? "" : ", ") + std::string(kind.name);
  return text;
}

const EncoderKind& kind_of(const Field& f) {
  const EncoderKind* found = nullptr;
  for (const EncoderKind& kind : encoder_kinds()) {
    if (!f.node->find(kind.name)) continue;
    if (found)
      throw Error({f.node->place, f.path, "an encoder must be stated in one way",
                   "'" + std::string(found->name) + "' and '" + std::string(kind.name) + "'",
                   "keep one of them"});
    found = &kind;
  }
  if (found) return *found;
  std::vector<std::string> known;
  for (const EncoderKind& kind : encoder_kinds()) known.emplace_back(kind.name);
  for (const auto& [key, value] : read_map(f))
    if (!nearest(key.name, known).empty())
      throw Error(
          {key.place, value.path, "unknown key", "'" + key.name + "'", did_you_mean(key.name, known)});
  throw Error({f.node->place, f.path, "the encoder's counts are missing", described(*f.node),
               "give one of " + list_of_kinds()});
}

std::vector<Parameter> format_of(const EncoderKind& kind) {
  std::vector<Parameter> rows = kind.parameters;
  for (const Parameter& p : common_encoder_parameters()) rows.push_back(p);
  return rows;
}

void refuse_key(const Object& o, std::string_view key, const std::string& why, const std::string& remedy) {
  if (o.has(key)) throw Error(o.at(key).fault(why, remedy));
}

/// Joint travel per encoder-shaft revolution before the gear: 2 pi, or the travel of screw or pulley.
double travel_of(const Object& o, const IndependentJoint& joint) {
  if (!joint.prismatic()) {
    refuse_key(o, "travel_per_rev", "joint '" + joint.name + "' is not prismatic", "remove travel_per_rev");
    return 2 * std::numbers::pi;
  }
  if (const auto travel = o.number("travel_per_rev")) return *travel;
  throw Error({o.self().node->place, o.self().path, "a prismatic joint needs its travel per revolution",
               described(*o.self().node),
               "add travel_per_rev: 10 mm (screw lead or pulley travel), or give " +
                   std::string(first_kind(true).example)});
}

std::pair<Encoder, EncoderFigures> read_encoder(const Field& f, const IndependentJoint& joint) {
  if (f.node->type == Node::Type::mapping)
    refuse_ambiguous_keys(f);
  else
    throw Error(f.fault("must be a mapping", "write {" + std::string(first_kind(false).example) + "}"));
  const EncoderKind& kind = kind_of(f);
  const Object o(f, format_of(kind));
  const auto numbers = o.numbers(kind.parameters, coordinate_dimension(joint));
  Encoder encoder;
  encoder.rounding = o.choice("rounding") == "down" ? Rounding::down : Rounding::nearest;
  encoder.zero_known = o.choice("zero") == "known";
  EncoderFigures figures{std::string(kind.name), 0, 1};
  if (kind.counts_per_rev) {
    figures.counts_per_rev = kind.counts_per_rev(numbers, o.choices(kind.parameters));
    figures.gear_ratio = o.number("gear_ratio").value();
    if (figures.gear_ratio == 0)
      throw Error(o.at("gear_ratio").fault("must not be zero", "encoder revolutions per joint revolution"));
    const double travel = travel_of(o, joint);
    encoder.resolution = travel / (figures.counts_per_rev * std::abs(figures.gear_ratio));
    encoder.shaft_ratio = 2 * std::numbers::pi * figures.gear_ratio / travel;
    if (kind.counts_per_period)
      encoder.counts_per_period = kind.counts_per_period(numbers, o.choices(kind.parameters));
  } else {
    refuse_key(o, "gear_ratio", "a resolution at the joint has no gear ratio", "remove gear_ratio");
    refuse_key(o, "travel_per_rev", "a resolution at the joint has no travel per revolution",
               "remove travel_per_rev");
    encoder.resolution = kind.resolution_at_joint(numbers, o.choices(kind.parameters));
    figures.counts_per_rev = 2 * std::numbers::pi / encoder.resolution;
  }
  if (!(encoder.resolution > 0) || !std::isfinite(encoder.resolution))
    throw Error({f.node->place, f.path, "the resolution must be a positive finite number",
                 shortest(encoder.resolution), "check counts and gear ratio"});
  if (!joint.prismatic() && encoder.resolution > 2 * std::numbers::pi)
    throw Error({f.node->place, f.path, "the encoder has less than one count per joint revolution",
                 shortest(encoder.resolution) + " rad a count",
                 "gear_ratio is encoder revolutions per joint revolution: is it inverted?"});
  return {encoder, figures};
}

}  // namespace

std::vector<std::string> joint_names(const Chain& chain) {
  std::vector<std::string> names;
  for (const IndependentJoint& joint : chain.independent) names.push_back(joint.name);
  return names;
}

std::size_t find_joint(const RobotModel& robot, const Chain& chain, const std::string& name,
                       const Place& place, const std::string& path) {
  const std::vector<std::string> names = joint_names(chain);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  for (const Joint& joint : robot.joints) {
    if (joint.name != name) continue;
    const std::string quoted = "'" + name + "'";
    if (joint.mimic)
      throw Error({place, path, "a mimic joint has no entry of its own",
                   quoted + ", which follows '" + joint.mimic->joint + "'",
                   "give it for '" + joint.mimic->joint + "'"});
    if (joint.type == JointType::fixed)
      throw Error({place, path, "the joint is fixed", quoted, did_you_mean("", names)});
    throw Error({place, path, "the joint is not between base and tip", quoted, did_you_mean("", names)});
  }
  throw Error({place, path, "unknown joint", "'" + name + "'", did_you_mean(name, names)});
}

bool off_chain(const RobotModel& robot, const Chain& chain, const std::string& name) {
  const auto is_it = [&](const auto& joint) { return joint.name == name; };
  const auto joint = std::find_if(robot.joints.begin(), robot.joints.end(), is_it);
  return joint != robot.joints.end() && joint->type != JointType::fixed && !joint->mimic &&
         std::none_of(chain.independent.begin(), chain.independent.end(), is_it);
}

void read_encoders(const Field& f, const RobotModel& robot, Spec& spec, Faults& faults) {
  const Chain& chain = spec.model.chain;
  std::vector<Field> of_joint(chain.independent.size());
  Field others;  // of `*`
  for (const auto& [key, value] : read_map(f)) {
    if (key.name == "*") {
      others = value;
    } else if (off_chain(robot, chain, key.name)) {
      spec.warnings.push_back("encoders." + key.name + " is not used: the joint is not between base and tip");
    } else {
      const Node::Key& joint = key;  // a structured binding cannot be captured
      const Field& entry = value;
      faults.guard([&] { of_joint[find_joint(robot, chain, joint.name, joint.place, entry.path)] = entry; });
    }
  }
  Transmission& transmission = spec.model.transmission;
  transmission.encoders.resize(of_joint.size());
  spec.encoder_figures.resize(of_joint.size());
  bool others_are_faulty = false;
  for (std::size_t i = 0; i < of_joint.size(); ++i) {
    const IndependentJoint& joint = chain.independent[i];
    if (!of_joint[i].node && others_are_faulty) continue;  // reported once, not for every joint
    const bool good = faults.guard([&] {
      if (!of_joint[i].node && !others.node)
        throw Error({f.node->place, f.path + '.' + joint.name, "the joint has no encoder", "",
                     "add '" + joint.name + ": {" + std::string(first_kind(false).example) +
                         "}', or '*' for all other joints"});
      const Field& entry = of_joint[i].node ? of_joint[i] : others;
      std::tie(transmission.encoders[i], spec.encoder_figures[i]) = read_encoder(entry, joint);
    });
    others_are_faulty = others_are_faulty || (!good && !of_joint[i].node && others.node);
  }
  const auto n = static_cast<Eigen::Index>(of_joint.size());
  transmission.coupling = Eigen::MatrixXd::Identity(n, n);
}

void read_coupling(const Field& f, Spec& spec) {
  const auto n = spec.model.chain.independent.size();
  const std::string shape =
      std::to_string(n) + " rows of " + std::to_string(n) + " numbers, one a joint in chain order";
  const std::vector<Field> rows = read_list(f);
  if (rows.size() != n) throw Error(f.fault("the coupling has the wrong size", shape));
  Eigen::MatrixXd coupling(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::vector<Field> row = read_list(rows[i]);
    if (row.size() != n) throw Error(rows[i].fault("the coupling has the wrong size", shape));
    for (std::size_t j = 0; j < n; ++j)
      coupling(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          read_number(row[j], {.name = "coupling"});
  }
  if (!coupling.allFinite() || rank(coupling) < static_cast<Eigen::Index>(n))
    throw Error({f.node->place, f.path, "the coupling is singular: a joint motion moves no encoder",
                 "rank " + std::to_string(rank(coupling)) + " of " + std::to_string(n), "check its rows"});
  spec.model.transmission.coupling = coupling;
}

}  // namespace qerr
