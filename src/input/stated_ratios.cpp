#include <algorithm>
#include <cmath>

#include "input/read_sections.hpp"
#include "qerr/encoder/encoder_kinds.hpp"

namespace qerr {

namespace {

constexpr double ratio_rounding = 1e-3;         // data sheets round: 36.17 is 36.167452
constexpr std::size_t most_contradictions = 6;  // joints in the warning

/// `'lift' -52143.3 (spec: 628.3 rad/m)`; "" where the two agree, or one of them is not stated.
std::string contradiction(const Joint& in_urdf, const Encoder& encoder, const EncoderFigures& figures,
                          bool prismatic) {
  // 1 is the placeholder of every template of a <transmission>.
  if (!in_urdf.stated_ratio || std::abs(*in_urdf.stated_ratio) == 1) return "";
  if (!encoder_kind(figures.kind).counts_per_rev) return "";
  const double stated = *in_urdf.stated_ratio, used = encoder.shaft_ratio;
  if (std::abs(used - stated) <= ratio_rounding * std::abs(stated)) return "";
  return "'" + in_urdf.name + "' " + shortest(stated) + " (spec: " +
         (prismatic ? shortest(used) + " rad of the encoder per metre" : "gear_ratio " + shortest(used)) +
         ")";
}

}  // namespace

void warn_of_stated_ratios(const RobotModel& robot, Spec& spec) {
  std::string text;
  std::size_t count = 0;
  for (std::size_t i = 0; i < spec.model.chain.independent.size(); ++i) {
    const IndependentJoint& joint = spec.model.chain.independent[i];
    const auto in_urdf = std::find_if(robot.joints.begin(), robot.joints.end(),
                                      [&](const Joint& j) { return j.name == joint.name; });
    const std::string found = contradiction(*in_urdf, spec.model.transmission.encoders[i],
                                            spec.encoder_figures[i], joint.prismatic());
    if (found.empty()) continue;
    if (++count <= most_contradictions) text += (text.empty() ? "" : ", ") + found;
  }
  if (count > most_contradictions) text += " and " + std::to_string(count - most_contradictions) + " more";
  if (count > 0)
    spec.warnings.push_back("the URDF states other ratios (mechanical reduction) than the spec: " + text +
                            "; the spec's are used: check which is right, and on which side of the gear the "
                            "encoder is");
}

}  // namespace qerr
