#include "qerr/input/first_spec.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/joint_entries.hpp"
#include "input/read_sections.hpp"
#include "input/urdf_reader.hpp"
#include "input/yaml_tree.hpp"
#include "qerr/encoder/encoder.hpp"
#include "qerr/filter/family.hpp"

namespace qerr {

namespace {

constexpr const char* assumed = "ASSUMED";
constexpr std::size_t comment_width = 100;
constexpr std::size_t most_tried_ends = 50;  // where the chains to all of them have flaws
constexpr std::size_t most_other_ends = 4;   // in the comment on the tip

/// Text as a value or key of YAML. A value that YAML could take for a number or for nothing is quoted.
std::string yaml_text(const std::string& text) {
  return flow_scalar(text, text == "~" || text == "null" || parse_number(text).has_value());
}

/// The example of the first kind of encoder that satisfies the condition.
template <class Condition>
Node example_of(Condition condition) {
  const auto& kinds = encoder_kinds();
  const auto kind = std::ranges::find_if(kinds, condition);
  return parse_yaml("{" + std::string(kind->example) + "}", "example");
}

void set(Node& entry, const std::string& key, const std::string& text) {
  if (Node* value = entry.find(key))
    *value = scalar_node(text);
  else
    entry.entries.push_back({{key, {}}, scalar_node(text)});
}

/// An entry of `encoders:` and what is assumed in it.
struct AssumedEncoder {
  Node entry;
  std::string assumption;
};

/// An encoder on the motor of a gear or a screw. @param travel  per motor revolution, of a prismatic joint
/// whose ratio states it
AssumedEncoder motor_encoder(const IndependentJoint& joint, double ratio, std::optional<double> travel) {
  Node entry = example_of(
      [](const EncoderKind& k) { return k.counts_per_rev && k.absolute_within == AbsoluteRange::none; });
  set(entry, "gear_ratio", travel ? (ratio < 0 ? "-1" : "1") : shortest(ratio));
  if (!joint.prismatic())
    return {entry, std::abs(ratio) == 1
                       ? "the counts; the URDF's ratio of the motor is 1, a template's placeholder?"
                       : "the counts; the ratio is the URDF's"};
  set(entry, "travel_per_rev", travel ? shortest(rounded_to(*travel, 12)) + " m" : "10 mm");
  return {entry, travel ? "the counts; the travel is 2 pi m over the URDF's ratio " + shortest(ratio)
                        : "the counts, and the travel: the URDF's ratio is taken for the gear's"};
}

/// Of a motor that moves two joints; its entry is that of the joint in the same place.
std::optional<double> coupled_ratio(const std::vector<StatedCoupling>& couplings, const std::string& joint) {
  for (const StatedCoupling& c : couplings)
    for (std::size_t i = 0; i < 2; ++i)
      if (c.joints[i] == joint) return c.ratios[i];
  return std::nullopt;
}

AssumedEncoder assumed_encoder(const RobotModel& robot, const std::vector<StatedCoupling>& couplings,
                               const IndependentJoint& joint) {
  const Joint* const in_urdf = find_named(robot.joints, joint.name);
  const auto coupled = coupled_ratio(couplings, joint.name);
  if (coupled)
    return motor_encoder(
        joint, *coupled,
        joint.prismatic() ? std::optional(2 * std::numbers::pi / std::abs(*coupled)) : std::nullopt);
  const double ratio = in_urdf->stated_ratio.value_or(1);
  if (std::abs(ratio) != 1) return motor_encoder(joint, ratio, stated_travel(*in_urdf));
  if (joint.prismatic())
    return {example_of([](const EncoderKind& k) { return k.resolution_at_joint != nullptr; }),
            "a linear scale on the joint"};
  AssumedEncoder own{
      example_of([](const EncoderKind& k) { return k.absolute_within == AbsoluteRange::revolution; }),
      "an absolute encoder on the joint side"};
  if (ratio != -1) return own;
  set(own.entry, "gear_ratio", "-1");
  return {own.entry, own.assumption + ", which counts against it, as the URDF's motor turns"};
}

/// Whether all joints of the chain have the range [0, 0], which exporters write for limits that nobody
/// entered.
bool has_empty_ranges_only(const Chain& chain) {
  return std::ranges::all_of(chain.independent, [](const IndependentJoint& j) {
    return j.limits && j.limits->lower == j.limits->upper;
  });
}

/// The assumed entry of `configurations: {limits:}`; "" where the URDF has the range.
std::string assumed_range(const IndependentJoint& joint, bool empty) {
  if (joint.limits && !empty) return "";
  const std::string why = empty                                 ? "the URDF has the empty range [0, 0]"
                          : joint.type == JointType::continuous ? "a continuous joint has no limits"
                                                                : "the URDF has no limits";
  return block_key(yaml_text(joint.name), "    ") +
         (joint.prismatic() ? "[-250 mm, 250 mm]" : "[-180 deg, 180 deg]") + "  # " + assumed + ": " + why +
         '\n';
}

std::string other_ends(const RobotModel& robot, const Chain& chain) {
  std::string text;
  std::size_t count = 0;
  for (const TreeEnd& end : tree_ends(robot)) {
    if (end.tip == chain.tip || end.joints.empty()) continue;
    if (++count > most_other_ends) continue;
    text +=
        (text.empty() ? "" : ", ") + escaped(end.tip, 60) + " (" + std::to_string(end.joints.size()) + ")";
  }
  if (count > most_other_ends) text += " and " + std::to_string(count - most_other_ends) + " more";
  return text;
}

/// Whether the joints move the origin of the tip: a wheel only turns it.
bool moves_position(const Chain& chain) {
  const auto n = std::ssize(chain.independent);
  for (const double angle : {0.1, 0.7})
    if (jacobian(chain, Eigen::VectorXd::Constant(n, angle)).topRows(3).cwiseAbs().maxCoeff() > 1e-9)
      return true;
  return false;
}

std::string robot_section(const RobotModel& robot, const Chain& chain, const std::string& urdf) {
  const std::string others = other_ends(robot, chain);
  return "qerr: 1\nrobot:\n  urdf: " + yaml_text(urdf) + "\n  base: " + yaml_text(chain.base) +
         "\n  tip: " + yaml_text(chain.tip) + "  # " + counted(chain.joints.size(), "moving joint") + '\n' +
         (others.empty() ? ""
                         : wrapped("other tips (and their moving joints): " + others, comment_width, "  #   ",
                                   "  # ", LongWords::cut));
}

std::vector<StatedCoupling> couplings_in(const RobotModel& robot, const Chain& chain) {
  const std::vector<std::string> names = joint_names(chain);
  std::vector<StatedCoupling> found = robot.couplings;
  std::erase_if(found, [&](const StatedCoupling& c) {
    return std::ranges::any_of(c.joints, [&](const std::string& joint) { return !contains(names, joint); });
  });
  return found;
}

std::string encoder_line(const std::string& key, const AssumedEncoder& encoder) {
  return "  " + block_key(key, "  ") + flow(encoder.entry) + "  # " + assumed + ": " + encoder.assumption +
         '\n';
}

/// The fewest entries: '*' for the most common encoder, if several joints have it or all, and the others'.
std::string encoder_section(const RobotModel& robot, const Chain& chain,
                            const std::vector<StatedCoupling>& couplings) {
  std::vector<AssumedEncoder> encoders;
  std::map<std::string, std::size_t> uses;
  for (const IndependentJoint& joint : chain.independent) {
    encoders.push_back(assumed_encoder(robot, couplings, joint));
    ++uses[encoder_line("", encoders.back())];
  }
  const auto uses_of = [&](const AssumedEncoder& e) { return uses.at(encoder_line("", e)); };
  const AssumedEncoder common = *std::ranges::max_element(
      encoders, [&](const AssumedEncoder& a, const AssumedEncoder& b) { return uses_of(a) < uses_of(b); });
  const bool shared = uses_of(common) > 1 || encoders.size() == 1;
  std::string text = "encoders:\n", others;
  for (std::size_t i = 0; i < encoders.size(); ++i) {
    AssumedEncoder own = encoders[i];
    if (shared && encoder_line("", own) == encoder_line("", common)) continue;
    // An entry inherits nothing from '*', whose gear it must not seem to have.
    if (shared && common.entry.find("gear_ratio") && !chain.independent[i].prismatic() &&
        !own.entry.find("gear_ratio"))
      set(own.entry, "gear_ratio", "1");
    others += encoder_line(yaml_text(chain.independent[i].name), own);
  }
  if (shared)
    text += wrapped("joints " + list_of_names(joint_names(chain)) +
                        "; an entry under a joint's name describes that joint alone",
                    comment_width, "  # ", "  # ", LongWords::cut) +
            encoder_line("'*'", common);
  return text + others;
}

/// Joint angles = coupling * (motor angles / gear_ratio).
std::string coupling_section(const Chain& chain, const std::vector<StatedCoupling>& couplings) {
  if (couplings.empty()) return "";
  const std::vector<std::string> names = joint_names(chain);
  const auto n = std::ssize(names);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(n, n);
  std::string text =
      "coupling:  # joints = coupling * (encoders / gear_ratio), rows and columns in chain order\n";
  for (const StatedCoupling& c : couplings) {
    const auto at = [&](std::size_t i) { return std::ranges::find(names, c.joints[i]) - names.begin(); };
    for (std::size_t i = 0; i < 2; ++i)
      for (std::size_t k = 0; k < 2; ++k) matrix(at(i), at(k)) = c.coupling(i, k);
    text += wrapped("the URDF's " + escaped(c.type, 60) + ' ' + escaped(c.transmission, 60) +
                        ": its motors move " + list_of_names({c.joints[0], c.joints[1]}),
                    comment_width, "  # ", "  # ", LongWords::cut);
  }
  for (Eigen::Index i = 0; i < n; ++i)
    text += "  - [" + joined(Eigen::RowVectorXd(matrix.row(i)), ", ", shortest) + "]\n";
  return text;
}

std::string filter_section() {
  const auto& families = filter_families();
  const auto family =
      std::ranges::find_if(families, [](const FilterFamily& f) { return !f.velocity_orders.empty(); });
  return "filters:  # " + std::string(assumed) +
         ": how the controller derives a velocity; `qerr list filters` has more\n"
         "  velocity: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: " +
         std::string(family->name) + ", order: 2, cutoff: 50 Hz}}\n";
}

std::string configuration_section(const Chain& chain) {
  const bool empty = has_empty_ranges_only(chain);
  std::string limits;
  for (const IndependentJoint& joint : chain.independent) {
    const std::string range = assumed_range(joint, empty);
    if (!range.empty()) limits += "    " + range;
  }
  return limits.empty() ? "" : "configurations:\n  limits:\n" + limits;
}

}  // namespace

Chain first_chain(const RobotModel& robot, const std::string& base, const std::string& tip) {
  if (!tip.empty()) return make_chain(robot, base.empty() ? natural_base(robot, tip) : base, tip);
  std::optional<Error> first;
  std::size_t tried = 0;
  for (const TreeEnd& end : tree_ends(robot, base)) {
    if (end.joints.empty() || ++tried > most_tried_ends) continue;
    try {
      return make_chain(robot, base.empty() ? natural_base(robot, end.tip) : base, end.tip);
    } catch (const Error& e) {
      if (!first) first = e;
    }
  }
  if (first) throw *first;
  throw Error({robot.file}, "",
              base.empty() ? "no joint of this robot moves" : "no joint below the base moves",
              counted(robot.joints.size(), "joint") + ", none revolute, continuous or prismatic",
              "there is nothing to analyze");
}

std::string first_spec(const RobotModel& robot, const Chain& chain, const std::string& urdf) {
  const std::vector<StatedCoupling> couplings = couplings_in(robot, chain);
  return "# yaml-language-server: $schema=qerr.schema.json\n"
         "# (`qerr schema -o qerr.schema.json` writes it beside this file: editors then complete and check)\n"
         "# First spec of robot '" +
         escaped(robot.name) +
         "', from its URDF. It can be analyzed as it is.\n"
         "# What is marked ASSUMED is not in the URDF: replace it by the figures of the data sheets\n"
         "# (`qerr list encoders` shows every way to state an encoder), then `qerr analyze` this file.\n" +
         robot_section(robot, chain, urdf) + encoder_section(robot, chain, couplings) +
         coupling_section(chain, couplings) +
         (moves_position(chain)
              ? "coordinates: [x, y, z]  # of the tip, in the base frame; also rx ry rz\n"
              : "coordinates: [rx, ry, rz]  # the joints turn the tip but do not move it\n") +
         filter_section() + configuration_section(chain) +
         "# What the robot must reach, for `qerr check`:\n"
         "# requirements:\n"
         "#   - {quantity: position." +
         (moves_position(chain) ? "x.worst_case, statistic: max, at_most: 0.1 mm}\n"
                                : "rx.worst_case, statistic: max, at_most: 1 mrad}\n");
}

}  // namespace qerr
