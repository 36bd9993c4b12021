#include <gtest/gtest.h>

#include <filesystem>

#include "qerr/input/spec.hpp"

namespace qerr {
namespace {

const std::string planar_robot = std::string(QERR_SOURCE_DIR) + "/configs/planar_prr/";

/// A spec with comments, an unusual order and blank lines.
const std::string base =
    "# my arm\n"
    "qerr: 1\n"
    "robot: {urdf: planar_prr.urdf}   # beside this file\n"
    "\n"
    "encoders:\n"
    "  '*': {resolution: 1e-4}  # all\n"
    "filters:\n"
    "  v: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 2, cutoff: 50 Hz}}\n";

Spec spec_of(const std::string& text, const SpecOverrides& overrides = {}) {
  return parse_spec(text, planar_robot + "x.yaml", overrides);
}

std::string a_joint() { return spec_of(base).model.chain.independent.back().name; }

AddedEffect backlash(double gap = 0.1 + 0.2) {
  return {{"backlash", a_joint(), {{"gap", gap}}, {}}, "seen at every reversal"};
}

std::string extended(const std::string& text, const std::vector<AddedEffect>& effects,
                     const SpecOverrides& overrides = {}) {
  return extended_spec(spec_of(text, overrides), effects, "found in a log", planar_robot + "y.yaml");
}

TEST(ExtendedSpec, KeepsTheUsersTextAndAppends) {
  const std::string text = extended(base, {backlash()});
  EXPECT_EQ(text.substr(0, base.size()), base);
  EXPECT_NE(text.find("# found in a log\n"), std::string::npos);
  EXPECT_NE(text.find("# seen at every reversal\n"), std::string::npos);
}

TEST(ExtendedSpec, ReadsBackAsTheSameDoubles) {
  const AddedEffect sine{{"transmission_error",
                          a_joint(),
                          {{"amplitude", 1.0 / 3}, {"phase", -2.0 / 7}, {"order", 7.3}},
                          {{"shaft", "joint"}}},
                         ""};
  const Spec read = spec_of(extended(base, {backlash(), sine}));
  ASSERT_EQ(read.effects.size(), 2u);
  EXPECT_EQ(read.effects[0].number("gap"), 0.1 + 0.2);
  EXPECT_EQ(read.effects[1].number("amplitude"), 1.0 / 3);
  EXPECT_EQ(read.effects[1].number("phase"), -2.0 / 7);
  EXPECT_EQ(read.effects[1].number("order"), 7.3);
  EXPECT_EQ(read.effects[1].choices.at("shaft"), "joint");
}

TEST(ExtendedSpec, AppendsToTheEffectsInAnyLayout) {
  const std::string j = a_joint(), offset = "{type: offset, joint: " + j + ", offset: 1e-3}";
  const std::string blocks = "effects:\n- type: offset\n  joint: " + j + "\n  offset: 1e-3  # known\n";
  const std::vector<std::string> layouts{
      base + "effects: [" + offset + "]\n",
      base + "effects: [" + offset + ",]  # ours\n",
      base + "effects: [\n  " + offset + ",  # it's ] known\n]\n",
      base + "effects:\n  - " + offset + "\n# the end\n",
      base + "effects:\n    - " + offset + "\n\n# of the tip\ncoordinates: [x, y]\n",
      base + blocks + "coordinates: [x]\n",
      base + blocks,
      "effects:\n- " + offset + "\n" + base,
      base + "effects:\n- " + offset,  // no newline at the end
      base + "effects:\n- " + offset + "\n...\n",
  };
  for (const std::string& text : layouts) {
    SCOPED_TRACE(text);
    const std::string out = extended(text, {backlash(1e-3), backlash(2e-3)});
    const Spec read = spec_of(out);
    ASSERT_EQ(read.effects.size(), 3u) << out;
    EXPECT_EQ(read.effects[0].type, "offset");
    EXPECT_EQ(read.effects[1].number("gap"), 1e-3);
    EXPECT_EQ(read.effects[2].number("gap"), 2e-3);
  }
}

TEST(ExtendedSpec, ExtendsAnEmptyListAndASpecInFlowStyle) {
  EXPECT_EQ(spec_of(extended(base + "effects: []\n", {backlash(), backlash()})).effects.size(), 2u);
  const std::string json =
      R"({"qerr": 1, "robot": {"urdf": "planar_prr.urdf"}, "encoders": {"*": {"resolution": 1e-4}}})";
  const Spec read = spec_of(extended(json + "\n", {backlash(), backlash()}));
  EXPECT_EQ(read.effects.size(), 2u);
}

TEST(ExtendedSpec, WritesOverridesIntoTheText) {
  const SpecOverrides overrides{{{"filters.v.lowpass.cutoff", "20Hz"},
                                 {"encoders.*.rounding", "down"},
                                 {"configurations.count", "50"},
                                 {"coordinates", "[x, rz]"}},
                                {}};
  const std::string text = extended(base, {backlash()}, overrides);
  EXPECT_NE(text.find("'*': {resolution: 1e-4, rounding: down}  # all"), std::string::npos) << text;
  const Spec read = spec_of(text), wanted = spec_of(base, overrides);
  EXPECT_EQ(read.filters[0].norms.h2, wanted.filters[0].norms.h2);
  EXPECT_EQ(read.configurations.count, 50u);
  EXPECT_EQ(read.model.coordinates.size(), 2u);
  EXPECT_EQ(read.model.transmission.encoders[0].rounding, Rounding::down);
}

TEST(ExtendedSpec, RejectsAnOverrideThatTheLayoutDoesNotAllow) {
  const std::string blocks =
      "qerr: 1\nrobot: {urdf: planar_prr.urdf}\nencoders:\n  '*':\n    resolution: 1e-4\n";
  // The same overrides key by key are accepted.
  EXPECT_EQ(spec_of(extended(blocks, {}, {{{"encoders.*.resolution", "2e-4"}}, {}}))
                .model.transmission.encoders[0]
                .resolution,
            2e-4);
  EXPECT_THROW(extended(blocks, {}, {{{"encoders.*", "{bits: 12}"}}, {}}), Error);
}

TEST(ExtendedSpec, RefersToTheSameUrdfFromAnotherFolder) {
  const std::string target = std::string(QERR_SOURCE_DIR) + "/configs/scara/y.yaml";
  const std::string text = extended_spec(spec_of(base), {}, "r", target);
  EXPECT_NE(text.find("robot: {urdf: ../planar_prr/planar_prr.urdf}   # beside this file"), std::string::npos)
      << text;
  EXPECT_EQ(parse_spec(text, target).robot_name, spec_of(base).robot_name);
}

TEST(ExtendedSpec, ListsEffectsThatCannotBeSimulatedInAComment) {
  const AddedEffect filter{{"filter_mismatch", a_joint(), {{"cutoff", 12.0}}, {}}, "cutoff 12 Hz"};
  const std::string text = extended(base, {filter, backlash(-1), backlash(NAN), backlash()});
  EXPECT_EQ(spec_of(text).effects.size(), 1u);
  EXPECT_NE(text.find("# found, but not part of this model: filter_mismatch of "), std::string::npos) << text;
  EXPECT_NE(text.find("is out of range"), std::string::npos) << text;
  EXPECT_NE(text.find("gap is not known"), std::string::npos) << text;
}

TEST(ExtendedSpec, WritesMissedCountsAsIntegers) {
  const AddedEffect lost{{"missed_counts", a_joint(), {{"counts", -3.98}, {"time", 1.5}}, {}}, ""};
  EXPECT_EQ(spec_of(extended(base, {lost})).effects.at(0).number("counts"), -4);
}

TEST(ExtendedSpec, AddsOrReplacesAFoundFilter) {
  const auto with = [](const std::vector<AddedFilter>& filters) {
    return extended_spec(spec_of(base), {}, "found in a log", planar_robot + "y.yaml", filters);
  };
  const std::string beside = with({{"v_2", "first_order", 3, 12.5, "of the log"}});
  EXPECT_NE(beside.find("  # of the log\n"), std::string::npos) << beside;
  const Spec two = spec_of(beside);
  ASSERT_EQ(two.filters.size(), 2u);
  EXPECT_EQ(two.filters[0].filter.sample_rate, 1000);
  EXPECT_NE(two.filters[0].norms.h2, two.filters[1].norms.h2);
  const std::string instead = with({{"v", "first_order", 2, 12.5, "of the log"}});
  EXPECT_NE(instead.find("sample_rate: 1 kHz, lowpass: {family: first_order, order: 2, cutoff: 12.5 Hz}"),
            std::string::npos)
      << instead;
  EXPECT_NE(instead.find("# filters.v: of the log\n"), std::string::npos) << instead;
  EXPECT_EQ(spec_of(instead).filters.size(), 1u);
  const std::string refused = with({{"v", "first_order", 2, 600, "of the log"}});
  EXPECT_EQ(refused.substr(0, base.size()), base);
  EXPECT_NE(refused.find("# found, but not part of this model: filter v ("), std::string::npos) << refused;
}

TEST(ExtendedSpec, IsUnchangedExceptForACommentIfNothingIsFound) {
  EXPECT_EQ(extended(base, {}), base + "# found in a log\n");
}

// The tracked point is found in the axes of the tip, which a tool of the spec has turned.
TEST(ExtendedSpec, MovesTheToolToTheTrackedPoint) {
  const AddedEffect tool{{"tool", "tip", {{"x", 0.01}, {"y", -0.02}, {"z", 0.03}}, {}}, "of the target"};
  for (const std::string& present :
       {std::string(), std::string(", tool: {xyz: [0, 0, 120 mm], rpy: [0, 90 deg, 20 deg]}")}) {
    std::string text = base;
    text.replace(text.find("planar_prr.urdf"), std::string("planar_prr.urdf").size(),
                 "planar_prr.urdf" + present);
    const Spec before = spec_of(text), after = spec_of(extended(text, {tool, backlash()}));
    const Eigen::Vector3d by =
        before.model.chain.tip_offset.inverse() * after.model.chain.tip_offset.translation();
    EXPECT_LT((by - Eigen::Vector3d(0.01, -0.02, 0.03)).norm(), 1e-12);
    EXPECT_LT((before.model.chain.tip_offset.linear() - after.model.chain.tip_offset.linear()).norm(), 1e-12);
    EXPECT_EQ(after.effects.size(), 1U);
  }
}

// An entry of one joint beats a pattern of the same type: the delay of all is written joint by joint.
TEST(ExtendedSpec, WritesTheDelayOfTheTipForEveryJoint) {
  const auto late = [](const std::string& joint, double delay) {
    return AddedEffect{{"latency", joint, {{"delay", delay}}, {}}, "of the tracker"};
  };
  const Spec alone = spec_of(extended(base, {late("tip", 0.02)}));
  const std::size_t joints = alone.model.chain.independent.size();
  ASSERT_EQ(alone.effects.size(), joints);
  for (std::size_t j = 0; j < joints; ++j) {
    EXPECT_EQ(alone.effects[j].joint, alone.model.chain.independent[j].name);
    EXPECT_EQ(alone.effects[j].number("delay"), 0.02);
  }
  const Spec both = spec_of(extended(base, {late("tip", 0.02), late(alone.effects[0].joint, -0.01)}));
  double sum = 0;
  for (const Effect& e : both.effects)
    if (e.joint == alone.effects[0].joint) sum += e.number("delay");
  EXPECT_NEAR(sum, 0.01, 1e-15);
  EXPECT_EQ(both.effects.size(), joints + 1);
}

/// The encoder of the last joint follows the first one by a factor, beside what the spec has of couplings.
TEST(ExtendedSpec, StatesACouplingThatIsFound) {
  for (const std::string& present :
       {std::string(), std::string("coupling: [[1, 0, 0], [0, 1, 0.5], [0, 0, 1]]\n")}) {
    const Spec before = spec_of(base + present);
    const std::vector<IndependentJoint>& joints = before.model.chain.independent;
    const AddedEffect found{{"coupling_error", joints[2].name, {{"factor", 0.013}}, {{"of", joints[0].name}}},
                            "of the cable"};
    const Spec after = spec_of(extended(base + present, {found}));
    Eigen::MatrixXd expected = before.model.transmission.coupling.inverse().dense();
    expected(2, 0) += 0.013;
    EXPECT_LT((after.model.transmission.coupling.inverse().dense() - expected).cwiseAbs().maxCoeff(), 1e-15);
  }
}

// The second frame is found in the axes of the one that the spec states.
TEST(ExtendedSpec, MovesTheTrackerToTheFrameThatIsFound) {
  const Eigen::Vector3d turn(0.4, -0.3, 1.2), shift(0.1, -0.2, 0.3);
  const AddedEffect frame{
      {"frame",
       "tip",
       {{"x", shift[0]}, {"y", shift[1]}, {"z", shift[2]}, {"rx", turn[0]}, {"ry", turn[1]}, {"rz", turn[2]}},
       {}},
      "of the tracker"};
  for (const std::string& present :
       {std::string(), std::string(", tracker: {xyz: [0, 0, 120 mm], rpy: [30 deg, 90 deg, 20 deg]}")}) {
    std::string text = base;
    text.replace(text.find("planar_prr.urdf"), std::string("planar_prr.urdf").size(),
                 "planar_prr.urdf" + present);
    const Spec before = spec_of(text), after = spec_of(extended(text, {frame}));
    const Eigen::Vector3d p(0.3, -0.5, 0.7);
    const Eigen::Vector3d expected =
        shift + Eigen::AngleAxisd(turn.norm(), turn.normalized()) * (before.model.chain.tracker * p);
    EXPECT_LT((after.model.chain.tracker * p - expected).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace qerr
