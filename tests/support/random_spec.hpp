#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "qerr/core/quantity.hpp"
#include "support/random_chain.hpp"

/// Random specs and URDFs as texts, which can be written in other units and other orders.
namespace qerr::testing {

/// A number of a spec in SI units, and another unit of the same kind.
struct SpecNumber {
  double value = 0;
  std::string other = {};  ///< "": has no unit
  double per_si = 1;       ///< the other unit in one of SI
};

inline SpecNumber angle(double radians, bool degrees) {
  return degrees ? SpecNumber{radians, "deg", 180 / std::numbers::pi} : SpecNumber{radians, "mrad", 1e3};
}
inline SpecNumber length(double metres) { return {metres, "mm", 1e3}; }
inline SpecNumber frequency(double hertz) { return {hertz, "kHz", 1e-3}; }

/// How a spec is written.
struct Writing {
  bool other_units = false;
  Dice* shuffle = nullptr;  ///< the order of what has none; null: as drawn

  std::string operator()(const SpecNumber& w) const {
    if (w.other.empty() || !other_units) return shortest(w.value);
    return shortest(w.value * w.per_si) + ' ' + w.other;
  }
  std::string list(std::vector<std::string> entries, const char* separator = ", ") const {
    for (std::size_t i = entries.size(); shuffle && i > 1; --i)
      std::swap(entries[i - 1], entries[shuffle->below(i)]);
    std::string text;
    for (const std::string& entry : entries) text += (text.empty() ? "" : separator) + entry;
    return text;
  }
};

/// A mapping of a spec in one line.
struct SpecEntry {
  std::vector<std::pair<std::string, SpecNumber>> numbers;
  std::vector<std::pair<std::string, std::string>> words;

  std::string text(const Writing& w) const {
    std::vector<std::string> all;
    for (const auto& [key, word] : words) all.push_back(key + ": " + word);
    for (const auto& [key, number] : numbers) all.push_back(key + ": " + w(number));
    return "{" + w.list(all) + "}";
  }
  SpecNumber& number(const std::string& key) {
    return std::find_if(numbers.begin(), numbers.end(), [&](const auto& n) { return n.first == key; })
        ->second;
  }
};

/// A random spec of a random robot without branches.
struct RandomSpec {
  RobotModel robot;
  std::vector<std::pair<std::string, SpecEntry>> encoders;  ///< by joint; the first one by `resolution`
  std::vector<std::pair<std::string, std::vector<SpecNumber>>> limits;  ///< of `configurations`
  SpecEntry tool, lowpass;
  std::vector<SpecEntry> effects;
  std::size_t count = 1, seed = 1;
  std::string coordinates, frame, method, sweep;

  std::string urdf(const Writing&) const;
  /// @param urdf_name  relative to the spec
  std::string text(const Writing&, const std::string& urdf_name) const;
};

inline SpecEntry random_encoder(Dice& dice, bool prismatic, bool at_joint) {
  SpecEntry e;
  if (dice.chance(0.3)) e.words = {{"rounding", dice.chance(0.5) ? "down" : "nearest"}};
  if (at_joint || dice.chance(0.3)) {
    const double resolution = 1e-5 * std::pow(100, dice.between(0, 1));
    e.numbers = {{"resolution", prismatic ? length(resolution) : angle(resolution, dice.chance(0.5))}};
  } else {
    if (dice.chance(0.5))
      e.numbers = {{"bits", {12 + static_cast<double>(dice.below(9))}}};
    else
      e.numbers = {{"counts_per_rev", {500 + static_cast<double>(dice.below(9000))}}};
    e.numbers.push_back({"gear_ratio", {dice.between(-100, 100)}});
    if (prismatic) e.numbers.push_back({"travel_per_rev", length(dice.between(1e-3, 0.05))});
  }
  if (dice.chance(0.3)) {
    const double accuracy = dice.between(0, 1e-3);
    e.numbers.push_back({"accuracy", prismatic ? length(accuracy) : angle(accuracy, true)});
  }
  return e;
}

inline SpecEntry random_effect(Dice& dice, const std::string& joint, bool prismatic) {
  static const std::pair<const char*, const char*> kinds[] = {
      {"offset", "offset"}, {"backlash", "gap"}, {"noise", "sigma"}};
  const auto& [type, parameter] = kinds[dice.below(3)];
  const double size = dice.between(1e-6, 1e-3);
  return {{{parameter, prismatic ? length(size) : angle(size, dice.chance(0.5))}},
          {{"type", type}, {"joint", joint}}};
}

inline RandomSpec random_spec(Dice& dice) {
  ChainMix mix{1 + dice.below(5)};
  mix.square = dice.chance(0.5) ? 1 : 0;
  RandomSpec s{random_robot(dice, mix), {}, {}, {}, {}, {}, 1 + dice.below(60),
               1 + dice.below(1000),    {}, {}, {}, {}};
  for (Joint& joint : s.robot.joints) {
    if (joint.type == JointType::fixed) continue;
    const bool prismatic = joint.type == JointType::prismatic;
    if (prismatic)
      joint.limits = joint.mimic ? Limits{-50, 50} : Limits{-0.5, 0.8};
    else if (joint.mimic || dice.chance(0.3))
      joint.type = JointType::continuous;
    else
      joint.limits = Limits{-2.5, 2};
    if (joint.mimic) continue;
    s.encoders.push_back({joint.name, random_encoder(dice, prismatic, s.encoders.empty())});
    if (!joint.limits || dice.chance(0.3))
      s.limits.push_back(
          {joint.name, prismatic ? std::vector{length(dice.between(-0.5, 0)), length(0.7)}
                                 : std::vector{angle(dice.between(-2, 0), true), angle(1.9, false)}});
    if (dice.chance(0.3)) s.effects.push_back(random_effect(dice, joint.name, prismatic));
  }
  s.tool.words = {{"rpy", "[0.1, -0.2, 0.3]"}};
  s.lowpass = {
      {{"order", {1 + static_cast<double>(dice.below(4))}}, {"cutoff", frequency(dice.between(100, 400))}},
      {{"family", dice.chance(0.5) ? "first_order" : "butterworth"}}};
  s.coordinates = dice.chance(0.5) ? "[x, y, z]" : "[x, y, z, rx, ry, rz, xyz, rxyz]";
  s.frame = dice.chance(0.3) ? "tip" : "base";
  s.method = dice.chance(0.5) ? "sobol" : "random";
  return s;
}

inline std::string xyz_text(const Eigen::Vector3d& v) {
  return shortest(v.x()) + ' ' + shortest(v.y()) + ' ' + shortest(v.z());
}

inline std::string joint_text(const Joint& joint) {
  static const char* const types[] = {"revolute", "continuous", "prismatic", "fixed"};
  const Eigen::Vector3d angles = joint.origin.linear().eulerAngles(2, 1, 0);
  std::string text = "<joint name='" + joint.name + "' type='" + types[static_cast<int>(joint.type)] +
                     "'>\n" + "<parent link='" + joint.parent + "'/><child link='" + joint.child +
                     "'/>\n<origin xyz='" + xyz_text(joint.origin.translation()) + "' rpy='" +
                     xyz_text(angles.reverse()) + "'/>\n";
  if (joint.type != JointType::fixed) text += "<axis xyz='" + xyz_text(joint.axis) + "'/>\n";
  if (joint.limits)
    text += "<limit lower='" + shortest(joint.limits->lower) + "' upper='" + shortest(joint.limits->upper) +
            "' effort='1' velocity='1'/>\n";
  if (joint.mimic)
    text += "<mimic joint='" + joint.mimic->joint + "' multiplier='" + shortest(joint.mimic->multiplier) +
            "' offset='" + shortest(joint.mimic->offset) + "'/>\n";
  return text + "</joint>";
}

inline std::string RandomSpec::urdf(const Writing& w) const {
  std::vector<std::string> parts;
  for (const std::string& link : robot.links) parts.push_back("<link name='" + link + "'/>");
  for (const Joint& joint : robot.joints) parts.push_back(joint_text(joint));
  return "<robot name='random'>\n" + w.list(parts, "\n") + "\n</robot>\n";
}

inline std::string RandomSpec::text(const Writing& w, const std::string& urdf_name) const {
  std::vector<std::string> encoder_texts, limit_texts;
  for (const auto& [joint, encoder] : encoders) encoder_texts.push_back(joint + ": " + encoder.text(w));
  for (const auto& [joint, range] : limits)
    limit_texts.push_back(joint + ": [" + w(range[0]) + ", " + w(range[1]) + "]");
  std::string effect_texts;  // an order of its own: reports list them as they stand
  for (const SpecEntry& effect : effects) effect_texts += (effect_texts.empty() ? "" : ", ") + effect.text(w);
  std::vector<std::string> sections = {
      "qerr: 1",
      "robot: {" +
          w.list({"urdf: " + urdf_name, "tool: {xyz: [" + w(length(0.03)) + ", 0, " + w(length(-0.2)) +
                                            "], rpy: [0, " + w(angle(0.4, true)) + ", 0]}"}) +
          "}",
      "encoders: {" + w.list(encoder_texts) + "}",
      "coordinates: " + coordinates,
      "frame: " + frame,
      "filters: {velocity: {derivative: 1, sample_rate: " + w(frequency(1000)) +
          ", lowpass: " + lowpass.text(w) + "}}",
      "configurations: {" +
          w.list({"method: " + method, "count: " + std::to_string(count), "seed: " + std::to_string(seed),
                  "limits: {" + w.list(limit_texts) + "}"}) +
          "}",
      "effects: [" + effect_texts + "]"};
  if (!sweep.empty()) sections.push_back("sweep: " + sweep);
  return w.list(sections, "\n") + "\n";
}

}  // namespace qerr::testing
