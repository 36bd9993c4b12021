#include <algorithm>
#include <array>
#include <cmath>

#include "core/text.hpp"
#include "input/read_sections.hpp"
#include "input/urdf_reader.hpp"
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
  const bool of_gear = prismatic && !stated_travel(in_urdf);
  if (std::abs((of_gear ? figures.gear_ratio : used) - stated) <= ratio_rounding * std::abs(stated))
    return "";
  return "'" + in_urdf.name + "' " + shortest(stated) + " (spec: " +
         (prismatic && !of_gear ? shortest(used) + " rad of the encoder per metre"
                                : "gear_ratio " + shortest(used)) +
         ")";
}

/// The rows and columns of two joints of the spec's coupling.
Eigen::Matrix2d block_of(const Coupling& coupling, const std::array<Eigen::Index, 2>& at) {
  Eigen::Matrix2d block;
  block << coupling(at[0], at[0]), coupling(at[0], at[1]), coupling(at[1], at[0]), coupling(at[1], at[1]);
  return block;
}

/// Whether one column is the other, up to the rounding of data sheets. @param scaled  up to a factor, too
bool same_column(const Eigen::Vector2d& used, const Eigen::Vector2d& stated, bool scaled) {
  const double factor = scaled ? stated.dot(used) / used.squaredNorm() : 1;
  return (factor * used - stated).norm() <= ratio_rounding * stated.norm();
}

/// What the spec has instead of a coupling that the URDF states; "" where the two agree, in either order of
/// the motors.
std::string contradiction(const StatedCoupling& stated, const Spec& spec,
                          const std::array<Eigen::Index, 2>& at) {
  const Eigen::Matrix2d block = block_of(spec.model.transmission.coupling, at);
  Eigen::Matrix2d used = block;  // joint motion per motor angle
  std::array<double, 2> ratios{};
  for (std::size_t k = 0; k < 2; ++k) {
    const auto i = static_cast<std::size_t>(at[k]);
    if (!encoder_kind(spec.encoder_figures[i].kind).counts_per_rev) return "";
    ratios[k] = spec.encoder_figures[i].gear_ratio;
    used.col(static_cast<Eigen::Index>(k)) /= spec.model.transmission.encoders[i].shaft_ratio;
  }
  const auto same = [&](Eigen::Index column, std::size_t motor) {
    const double ratio = stated.ratios[motor];
    return same_column(used.col(column), stated.coupling.col(static_cast<Eigen::Index>(motor)) / ratio,
                       std::abs(ratio) == 1);
  };
  if ((same(0, 0) && same(1, 1)) || (same(0, 1) && same(1, 0))) return "";
  return quoted(stated.joints[0]) + " and " + quoted(stated.joints[1]) + " by the " + stated.type + ' ' +
         quoted(stated.transmission) + ": " + coupling_text(stated.ratios, stated.coupling) +
         " (spec: " + coupling_text(ratios, block) + ')';
}

/// Warns of couplings that the spec contradicts or cannot have. The joints of all of them.
std::vector<std::string> warn_of_couplings(const RobotModel& robot, Spec& spec) {
  std::vector<std::string> coupled;
  for (const StatedCoupling& stated : robot.couplings) {
    std::array<Eigen::Index, 2> at{-1, -1};
    for (std::size_t i = 0; i < 2; ++i)
      for (std::size_t j = 0; j < spec.model.chain.independent.size(); ++j)
        if (spec.model.chain.independent[j].name == stated.joints[i]) at[i] = static_cast<Eigen::Index>(j);
    coupled.insert(coupled.end(), stated.joints.begin(), stated.joints.end());
    if (at[0] < 0 && at[1] < 0) continue;
    if (at[0] < 0 || at[1] < 0) {
      const std::size_t in = at[0] < 0 ? 1 : 0;
      spec.warnings.push_back("the URDF couples " + quoted(stated.joints[in]) + " with " +
                              quoted(stated.joints[1 - in]) + ", which is not between base and tip, by the " +
                              stated.type + ' ' + quoted(stated.transmission) +
                              ": the share of a second motor in its error is not counted");
    } else if (const std::string found = contradiction(stated, spec, at); !found.empty()) {
      spec.warnings.push_back("the URDF couples joints otherwise than the spec: " + found +
                              "; the spec's is used: check which is right, and where the encoders are");
    }
  }
  return coupled;
}

}  // namespace

void warn_of_stated_ratios(const RobotModel& robot, Spec& spec) {
  const std::vector<std::string> coupled = warn_of_couplings(robot, spec);
  std::string text;
  std::size_t count = 0;
  for (std::size_t i = 0; i < spec.model.chain.independent.size(); ++i) {
    const IndependentJoint& joint = spec.model.chain.independent[i];
    if (std::find(coupled.begin(), coupled.end(), joint.name) != coupled.end()) continue;
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
