#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>

#include "qerr/input/spec.hpp"

namespace qerr {
namespace {

const std::string arm = R"(<robot name="arm">
  <link name="base"/><link name="upper"/><link name="fore"/><link name="tool"/><link name="finger"/><link name="side"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="lift" type="prismatic"><parent link="upper"/><child link="fore"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="0.3" effort="1" velocity="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="fore"/><child link="tool"/><origin xyz="0.4 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="grip" type="revolute"><parent link="tool"/><child link="finger"/><origin xyz="0.1 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="elbow" multiplier="-1"/></joint>
  <joint name="aside" type="revolute"><parent link="base"/><child link="side"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>)";

const std::string spec_head = "qerr: 1\nrobot: {urdf: arm.urdf, tip: finger}\n";
const std::string encoders =
    "encoders:\n  '*': {counts_per_rev: 4096, gear_ratio: 100}\n  lift: {resolution: 1 um}\n";

class ReadSpec : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("qerr_spec_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "arm.urdf") << arm;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Spec read(const std::string& text, const SpecOverrides& overrides = {}) {
    std::ofstream(folder_ / "spec.yaml") << text;
    return read_spec((folder_ / "spec.yaml").string(), overrides);
  }

  /// The message of a spec that must be rejected, without its folder.
  std::string refusal(const std::string& text, const SpecOverrides& overrides = {}) {
    try {
      read(text, overrides);
    } catch (const Error& e) {
      EXPECT_EQ(e.trouble(), Trouble::input);
      std::string message = e.what();
      for (std::size_t at; (at = message.find(folder_.string() + "/")) != std::string::npos;)
        message.erase(at, folder_.string().size() + 1);
      return message;
    }
    return "accepted";
  }

  std::filesystem::path folder_;
};

TEST_F(ReadSpec, AToolMovesTheTip) {
  const Spec bare = read(spec_head + encoders);
  const Spec spec = read(
      "qerr: 1\nrobot: {urdf: arm.urdf, tip: finger, tool: {xyz: [0, 20 mm, 0.1], rpy: [90 deg, 0, 30 "
      "deg]}}\n" +
      encoders + "frame: tip\n");
  const Eigen::VectorXd q = Eigen::Vector3d(0.3, 0.1, -0.4);
  const Eigen::Isometry3d link = forward_kinematics(bare.model.chain, q),
                          tool = forward_kinematics(spec.model.chain, q);
  EXPECT_LT((link.inverse() * tool.translation() - Eigen::Vector3d(0, 0.02, 0.1)).norm(), 1e-14);
  const Eigen::Matrix3d turned = link.linear().transpose() * tool.linear();
  // Rz(30 deg) Rx(90 deg): x of the tool is turned by the yaw alone, its y is z of the link.
  EXPECT_LT((turned.col(0) - Eigen::Vector3d(std::sqrt(0.75), 0.5, 0)).norm(), 1e-14);
  EXPECT_LT((turned.col(1) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-14);
  EXPECT_EQ(spec.model.frame, CoordinateFrame::tip);
  EXPECT_EQ(bare.model.frame, CoordinateFrame::base);
}

TEST_F(ReadSpec, ANamedEffectBeatsThePatternOfItsType) {
  const Spec spec = read(spec_head + encoders +
                         "effects:\n  - {type: backlash, joint: '[se]*', gap: 0.1 mrad}\n"
                         "  - {type: backlash, joint: elbow, gap: 0.3 mrad}\n");
  std::map<std::string, std::vector<double>> gaps;
  for (const Effect& e : spec.effects) gaps[e.joint].push_back(e.number("gap"));
  EXPECT_EQ(gaps["elbow"], std::vector<double>{0.3e-3});
  EXPECT_EQ(gaps["shoulder"], std::vector<double>{0.1e-3});
}

TEST_F(ReadSpec, ALengthBringsItsComponents) {
  const Spec spec = read(spec_head + encoders + "coordinates: [rxyz, z]\n");
  EXPECT_EQ(spec.model.coordinates,
            (std::vector<Coordinate>{Coordinate::z, Coordinate::rx, Coordinate::ry, Coordinate::rz}));
  EXPECT_EQ(spec.model.lengths, std::vector<Coordinate>{Coordinate::rxyz});
}

TEST_F(ReadSpec, ConvertsEveryEncoderKindToTheJointSide) {
  const Spec spec =
      read(spec_head +
           "encoders:\n  shoulder: {lines_per_rev: 1024, decoding: x2, gear_ratio: -80}\n"
           "  elbow: {periods_per_rev: 16, interpolation_bits: 10, rounding: down, zero: free}\n"
           "  lift: {bits: 12, gear_ratio: 5, travel_per_rev: 10 mm}\n");
  const auto& e = spec.model.transmission.encoders;
  ASSERT_EQ(e.size(), 3u);  // the mimic has none of its own
  EXPECT_DOUBLE_EQ(e[0].resolution, 2 * std::numbers::pi / (2048 * 80));
  EXPECT_DOUBLE_EQ(e[1].resolution, 0.01 / (4096 * 5));
  EXPECT_DOUBLE_EQ(e[2].resolution, 2 * std::numbers::pi / (16 * 1024));
  EXPECT_EQ(e[2].rounding, Rounding::down);
  EXPECT_FALSE(e[2].zero_known);
  EXPECT_EQ(spec.encoder_figures[0].gear_ratio, -80);
}

// Sobol's sequence is tabulated for 3667 dimensions.
TEST_F(ReadSpec, SamplesRobotsOfThousandsOfJointsAtRandom) {
  const auto method_of = [&](int joints) {
    std::string urdf = "<robot name='long'><link name='l0'/>";
    for (int j = 1; j <= joints; ++j) {
      const std::string n = std::to_string(j);
      urdf += "<link name='l" + n + "'/><joint name='j" + n + "' type='revolute'><parent link='l" +
              std::to_string(j - 1) + "'/><child link='l" + n +
              "'/><axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>";
    }
    std::ofstream(folder_ / "long.urdf") << urdf << "</robot>";
    const Spec spec = read("qerr: 1\nrobot: {urdf: long.urdf}\nencoders: {'*': {bits: 12}}\n");
    EXPECT_EQ(spec.warnings.size(), joints > 3667 ? 1u : 0u);
    return spec.configurations.method;
  };
  EXPECT_EQ(method_of(3667), SamplingMethod::sobol);
  EXPECT_EQ(method_of(3668), SamplingMethod::random);
}

TEST_F(ReadSpec, DefaultsToPositionsAndTenThousandSobolPoints) {
  const Spec spec = read(spec_head + encoders);
  EXPECT_EQ(spec.model.coordinates, (std::vector{Coordinate::x, Coordinate::y, Coordinate::z}));
  EXPECT_EQ(size(spec.configurations), 10000u);
  EXPECT_EQ(spec.configurations.seed, 1u);
  EXPECT_EQ(spec.configurations.ranges[1].upper, 0.3);
}

TEST_F(ReadSpec, PointsAtTheKeyAndSuggestsTheRightName) {
  EXPECT_EQ(
      refusal(spec_head +
              "encoders:\n  '*': {counts_per_rev: 4096, gear_ration: 100}\n  lift: {resolution: 1 um}\n"),
      "spec.yaml:4:31: encoders.*.gear_ration: unknown key, found 'gear_ration'; did you mean 'gear_ratio'?");
  EXPECT_NE(refusal(spec_head + "encodrs: {}\n" + encoders)
                .find("spec.yaml:3:1: encodrs: unknown key, found 'encodrs'; did you mean 'encoders'?"),
            std::string::npos);
}

// A turn has all positions of a continuous joint.
TEST_F(ReadSpec, SamplesAWholeTurnOfAContinuousJoint) {
  std::string endless = arm;
  endless.replace(endless.find("type=\"revolute\""), std::string("type=\"revolute\"").size(),
                  "type=\"continuous\"");
  std::ofstream(folder_ / "arm.urdf") << endless;
  const Spec spec = read(spec_head + encoders);
  EXPECT_NEAR(spec.configurations.ranges[0].upper, std::numbers::pi, 1e-15);
  EXPECT_NEAR(spec.configurations.ranges[0].lower, -std::numbers::pi, 1e-15);
  ASSERT_EQ(std::count_if(spec.warnings.begin(), spec.warnings.end(),
                          [](const std::string& w) {
                            return w.find("continuous joints without limits, 'shoulder': a whole turn") == 0;
                          }),
            1);
  const Spec narrow =
      read(spec_head + encoders + "configurations: {limits: {shoulder: [-90 deg, 90 deg]}}\n");
  EXPECT_NEAR(narrow.configurations.ranges[0].upper, std::numbers::pi / 2, 1e-15);
  for (const std::string& w : narrow.warnings) EXPECT_EQ(w.find("whole turn"), std::string::npos) << w;
}

TEST_F(ReadSpec, ReportsSeveralFaultsTogether) {
  const std::string text = refusal(
      spec_head + "encoders:\n  shoulder: {bits: 99}\n  lift: {resolution: 1 deg}\n  elbow: {cpr: 5}\n");
  EXPECT_NE(text.find("spec.yaml:4:20: encoders.shoulder.bits: is out of range, found '99'"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("encoders.lift.resolution: has the wrong kind of unit"), std::string::npos) << text;
  EXPECT_NE(text.find("'cpr' is ambiguous"), std::string::npos) << text;
}

TEST_F(ReadSpec, RejectsInvalidSections) {
  const struct {
    const char* text;
    const char* message;
  } cases[] = {
      {"coupling: [[1, 0, 0], [0, 1, 0], [1, 0, 0]]\n", "the coupling is singular"},
      {"coupling: [[1, 0], [0, 1]]\n", "the coupling has the wrong size"},
      {"coordinates: [x, x]\n", "duplicate coordinate"},
      {"coordinates: [x, rol]\n", "did you mean 'roll'?"},
      {"filters: {v: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, cutoff: 500 Hz}}}\n",
       "below half the sample rate"},
      {"filters: {v: {sample_rate: 1 kHz, numerator: [1], denominator: [1, -1]}}\n", "filters.v.denominator"},
      {"filters: {v: {derivative: 1, sample_rate: 1 s}}\n", "wrong kind of unit"},
      {"filters: {position: {derivative: 1, sample_rate: 1 kHz}}\n", "the name is reserved"},
      {"configurations: {limits: {elbow: [-3, 3]}}\n", "the limits exceed those of the URDF"},
      {"configurations: {limits: {elbow: [1, -1]}}\n", "the lower limit is above the upper one"},
      {"configurations: {limits: {grip: [-1, 1]}}\n", "a mimic joint has no entry of its own"},
      {"configurations: {method: list, points: [[0, 0]]}\n", "a point must have one value per joint: 3"},
      {"configurations: {method: list, points: [[0, 0, 90]]}\n", "degrees need their unit"},
      {"configurations: {method: list, points: []}\n", "the list is empty"},
      {"configurations: {method: list, count: 3, points: [[0, 0, 0]]}\n",
       "cannot be combined with method: list"},
      {"configurations: {count: 0}\n", "out of range"},
      {"configurations: {count: 2.5}\n", "must be an integer"},
      {"requirements: [{quantity: velocity.x.sigma, statistic: p99, at_most: 1}]\n",
       "no such filter 'velocity'"},
      {"requirements: [{quantity: position.x.sigma, statistic: p98, at_most: 1}]\n", "did you mean 'p9"},
      {"requirements: [{quantity: position.x.sigma, statistic: max, at_most: 1 rad}]\n",
       "wrong kind of unit"},
      {"motion: {sample_rate: 1 kHz, duration: 1 s, joints: {elbw: {}}}\n", "did you mean 'elbow'?"},
      {"effects: [{type: backlsh, joint: elbow, gap: 1 mrad}]\n", "did you mean 'backlash'?"},
      {"effects: [{type: backlash, joint: elbow}]\n", "effects[0].gap: missing key"},
      {"sweep: [{key: encoders.elbow.bitz, values: [13, 15]}]\n", "sweep[0]"},
      {"sweep: [{key: encoders.elbow.gear_ratio, from: 10, to: 0, count: 3, scale: log}]\n", "positive ends"},
      {"threshold: {length: 300}\nthreshold: {length: 1}\n", "duplicate key"},
      {"---\nqerr: 1\n", "a second YAML document"},
      {"robot2: &a {}\n", "anchors are not supported"},
      {"threshold: {length: 010}\n", "a leading zero is ambiguous"},
      {"threshold: {length: '3}\n", "a quotation mark is not closed"},
  };
  for (const auto& c : cases) {
    const std::string message = refusal(spec_head + encoders + c.text);
    EXPECT_NE(message.find(c.message), std::string::npos) << c.text << message;
    EXPECT_EQ(message.substr(0, 10), "spec.yaml:") << message;
  }
}

TEST_F(ReadSpec, AppliesOverridesByDottedPath) {
  SpecOverrides overrides;
  overrides.values = {{"encoders.elbow.bits", "19"}, {"coordinates", "[y]"}};
  overrides.seed = 7;
  const Spec spec = read(spec_head + encoders + "  elbow: {bits: 17}\n", overrides);
  EXPECT_DOUBLE_EQ(spec.model.transmission.encoders[2].resolution, 2 * std::numbers::pi / 524288);
  EXPECT_EQ(spec.model.coordinates, std::vector{Coordinate::y});
  EXPECT_EQ(spec.configurations.seed, 7u);
  EXPECT_EQ(spec.overrides.size(), 2u);
  overrides.values = {{"encoders.elbow.bts", "19"}};
  EXPECT_EQ(refusal(spec_head + encoders, overrides).substr(0, 26), "--set encoders.elbow.bts: ");
}

/// Resolution of an encoder of 4096 counts behind a gear of 100.
constexpr double geared = 2 * std::numbers::pi / 409600;

TEST_F(ReadSpec, ANamedEntryBeatsAPatternAndTwoPatternsForAJointAreAnError) {
  const auto resolution = [](const Spec& s, std::size_t i) {
    return s.model.transmission.encoders[i].resolution;
  };
  for (const char* text :
       {"encoders:\n  'l*': {resolution: 1 um}\n  '[es]*': {counts_per_rev: 4096, gear_ratio: 100}\n",
        "encoders:\n  elbow: {counts_per_rev: 4096, gear_ratio: 100}\n  shoulde?: {counts_per_rev: "
        "4096, gear_ratio: 100}\n  '*ift': {resolution: 1 um}\n"}) {
    const Spec spec = read(spec_head + text);
    EXPECT_DOUBLE_EQ(resolution(spec, 0), geared) << text;
    EXPECT_DOUBLE_EQ(resolution(spec, 1), 1e-6) << text;
    EXPECT_DOUBLE_EQ(resolution(spec, 2), geared) << text;
  }
  EXPECT_EQ(
      refusal(spec_head + encoders + "  'e*': {bits: 17}\n"),
      "spec.yaml:6:9: encoders.e*: two patterns fit joint 'elbow', found encoders.* and encoders.e*; write "
      "the joint's own name, or patterns that exclude each other");
  // The order of the entries does not matter, and a name that beats both patterns leaves nothing to decide.
  EXPECT_NE(
      refusal(spec_head + "encoders:\n  'e*': {bits: 17}\n  lift: {resolution: 1 um}\n  '*': {bits: 12}\n")
          .find("encoders.e* and encoders.*"),
      std::string::npos);
  EXPECT_DOUBLE_EQ(
      resolution(read(spec_head + encoders + "  'e*': {bits: 12}\n  elbow: {bits: 17, gear_ratio: 1}\n"), 2),
      2 * std::numbers::pi / 131072);
}

TEST_F(ReadSpec, APatternThatFitsNoJointIsAnErrorWithTheJoints) {
  EXPECT_EQ(refusal(spec_head + encoders + "  'left_*': {bits: 17}\n"),
            "spec.yaml:6:3: encoders.left_*: the pattern fits no joint between base and tip, found 'left_*'; "
            "known: "
            "shoulder, lift, elbow");
  EXPECT_NE(refusal(spec_head + encoders + "configurations: {limits: {'j[1-3]': [0, 1]}}\n")
                .find("configurations.limits.j[1-3]"),
            std::string::npos);
  EXPECT_NE(refusal(spec_head + encoders + "effects: [{type: backlash, joint: 'x*', gap: 1 mrad}]\n")
                .find("effects[0].joint"),
            std::string::npos);
  const Spec spec = read(spec_head + encoders + "  'as*': {bits: 17}\n");
  ASSERT_EQ(spec.warnings.size(), 1u);
  EXPECT_NE(spec.warnings[0].find("encoders.as* is not used"), std::string::npos);
}

TEST_F(ReadSpec, AnEntryThatLosesThePatternsGearIsAnErrorOrAWarning) {
  EXPECT_EQ(refusal(spec_head + encoders + "  elbow: {counts_per_rev: 8192}\n"),
            "spec.yaml:6:10: encoders.elbow: the entry states no gear_ratio, but encoders.*, which it "
            "replaces wholly, "
            "has gear_ratio: 100, found a mapping; add gear_ratio: 100, or gear_ratio: 1 for an encoder at "
            "the joint");
  EXPECT_TRUE(
      read(spec_head + encoders + "  elbow: {counts_per_rev: 8192, gear_ratio: 1}\n").warnings.empty());
  const Spec other = read(spec_head + encoders + "  elbow: {bits: 17}\n");
  ASSERT_EQ(other.warnings.size(), 1u);
  EXPECT_NE(other.warnings[0].find("encoders.elbow states no gear_ratio: 1 holds, where encoders.*"),
            std::string::npos);
  EXPECT_TRUE(read(spec_head + encoders + "  elbow: {bits: 17, gear_ratio: 1}\n").warnings.empty());
  EXPECT_TRUE(read(spec_head + encoders + "  elbow: {resolution: 1 mrad}\n").warnings.empty());
}

TEST_F(ReadSpec, AnOverrideChangesOneValueOfWhatHoldsForTheJoint) {
  const auto elbow = [&](const std::string& text, const std::string& key, const std::string& value) {
    SpecOverrides overrides;
    overrides.values = {{key, value}};
    return read(text, overrides).model.transmission.encoders[2].resolution;
  };
  EXPECT_DOUBLE_EQ(elbow(spec_head + encoders, "encoders.elbow.counts_per_rev", "8192"), geared / 2);
  EXPECT_DOUBLE_EQ(elbow(spec_head + encoders, "encoders.elbow.gear_ratio", "1/50"), geared * 5000);
  EXPECT_DOUBLE_EQ(elbow(spec_head + encoders, "encoders.elbow.bits", "13"), geared / 2);
  EXPECT_DOUBLE_EQ(elbow(spec_head + encoders, "encoders.elbow.resolution", "1 mrad"), 1e-3);
  EXPECT_DOUBLE_EQ(elbow(spec_head + encoders, "encoders.*.counts_per_rev", "2048"), 2 * geared);
  const std::string lines =
      "encoders:\n  '*': {lines_per_rev: 1024, decoding: x1, gear_ratio: 100}\n  lift: {resolution: 1 um}\n";
  EXPECT_DOUBLE_EQ(elbow(spec_head + lines, "encoders.elbow.lines_per_rev", "4096"), geared);
  EXPECT_DOUBLE_EQ(elbow(spec_head + lines, "encoders.elbow.counts_per_rev", "4096"), geared);
}

TEST_F(ReadSpec, TheOrderOfOverridesOfAPatternAndOfAJointDoesNotMatter) {
  std::vector<std::pair<std::string, std::string>> values{{"encoders.elbow.counts_per_rev", "8192"},
                                                          {"coordinates", "[x]"},
                                                          {"encoders.*.gear_ratio", "50"},
                                                          {"encoders.elbow.rounding", "down"}};
  for (int i = 0; i < 4; ++i) {
    SpecOverrides overrides;
    overrides.values = values;
    const Encoder elbow = read(spec_head + encoders, overrides).model.transmission.encoders[2];
    EXPECT_DOUBLE_EQ(elbow.resolution, geared);
    EXPECT_EQ(elbow.rounding, Rounding::down);
    std::rotate(values.begin(), values.begin() + 1, values.end());
  }
}

TEST_F(ReadSpec, AnOverrideNamesItemsOfListsInTwoWaysAndNeverCreatesWhatIsNotRead) {
  const std::string text = spec_head + encoders +
                           "filters: {velocity: {derivative: 1, sample_rate: 1 kHz}}\n"
                           "requirements: [{quantity: position.x.sigma, statistic: max, at_most: 1 mm}]\n";
  for (const char* key : {"requirements.0.at_most", "requirements[0].at_most"}) {
    SpecOverrides overrides;
    overrides.values = {{key, "2 mm"}};
    EXPECT_EQ(read(text, overrides).requirements[0].limit, 2e-3) << key;
  }
  const struct {
    const char* key;
    const char* message;
  } cases[] = {
      {"requirements[1].at_most",
       "'requirements' is a list of 1 item, counted from 0, found '[1].at_most'; give requirements[0]"},
      {"filters.velocty.sample_rate",
       "the spec has no filter of this name, found 'velocty'; did you mean 'velocity'?"},
      {"encoders.elbw.bits", "encoders.elbw: unknown joint, found 'elbw'; did you mean 'elbow'?"},
      {"effects[0].gap", "the spec has no effects"},
      {"robot.urdf.path", "'robot.urdf' is a single value and has no keys"},
      {"encoders.elbow.gear_ratio", "a ratio is written as a fraction, found '1:50'; write 1/50"},
  };
  for (const auto& c : cases) {
    SpecOverrides overrides;
    overrides.values = {{c.key, "1:50"}};
    const std::string message = refusal(text, overrides);
    EXPECT_EQ(message.find("--set " + std::string(c.key) + ": "), 0u) << message;
    EXPECT_NE(message.find(c.message), std::string::npos) << message;
  }
}

TEST_F(ReadSpec, NamesThePrismaticJointThatAPatternDoesNotDescribe) {
  EXPECT_NE(refusal(spec_head + "encoders:\n  '*': {counts_per_rev: 4096, gear_ratio: 100}\n")
                .find("encoders.*: joint 'lift' is prismatic and needs its travel per revolution, found a "
                      "mapping; write "
                      "'lift: {"),
            std::string::npos);
  const std::string mixed = refusal(spec_head + encoders + "configurations: {limits: {'*': [0, 10 mm]}}\n");
  EXPECT_NE(mixed.find("has the wrong kind of unit: this is a length (joints 'shoulder', 'elbow')"),
            std::string::npos)
      << mixed;
  EXPECT_EQ(mixed.find('\n'), std::string::npos) << mixed;
  // The travel in a pattern is that of its prismatic joints.
  const Spec spec =
      read(spec_head + "encoders:\n  '*': {counts_per_rev: 4096, gear_ratio: 100, travel_per_rev: 5 mm}\n");
  EXPECT_DOUBLE_EQ(spec.model.transmission.encoders[1].resolution, 5e-3 / 409600);
  EXPECT_DOUBLE_EQ(spec.model.transmission.encoders[2].resolution, geared);
}

TEST_F(ReadSpec, AnEffectActsOnEveryJointOfItsPattern) {
  const Spec spec = read(spec_head + encoders + "effects: [{type: backlash, joint: '[se]*', gap: 1 mrad}]\n");
  ASSERT_EQ(spec.effects.size(), 2u);
  EXPECT_EQ(spec.effects[0].joint, "shoulder");
  EXPECT_EQ(spec.effects[1].joint, "elbow");
  EXPECT_NE(refusal(spec_head + encoders + "effects: [{type: backlash, joint: '*', gap: 1 mrad}]\n")
                .find("effects[0].gap: has the wrong kind of unit: this is an angle (joint 'lift')"),
            std::string::npos);
}

TEST_F(ReadSpec, BringsTheAccuracyOfTheShaftToTheJoint) {
  constexpr double arcsec = std::numbers::pi / 648000;
  const Spec spec = read(
      spec_head +
      "encoders:\n  shoulder: {bits: 17, accuracy: 20 arcsec}\n  lift: {counts_per_rev: 4096, gear_ratio: "
      "-5, travel_per_rev: 10 mm, accuracy: 36 arcsec}\n  elbow: {bits: 17, gear_ratio: 100, "
      "accuracy: 20 arcsec}\n");
  const auto& e = spec.model.transmission.encoders;
  EXPECT_DOUBLE_EQ(e[0].accuracy, 20 * arcsec);
  EXPECT_DOUBLE_EQ(e[1].accuracy, 0.01 / 5 * 36 / 1296000);  // of a screw that turns five times slower
  EXPECT_DOUBLE_EQ(e[2].accuracy, 0.2 * arcsec);
  const Spec scale =
      read(spec_head +
           "encoders:\n  '*': {resolution: 1 urad, accuracy: 5 urad}\n  lift: {resolution: 1 um, "
           "accuracy: 5 um}\n");
  EXPECT_DOUBLE_EQ(scale.model.transmission.encoders[1].accuracy, 5e-6);
  EXPECT_DOUBLE_EQ(scale.model.transmission.encoders[2].accuracy, 5e-6);
}

TEST_F(ReadSpec, WarnsOfWhatIsValidAndProbablyNotMeant) {
  const struct {
    const char* text;
    const char* warning;
  } cases[] = {
      {"  elbow: {counts_per_rev: 4096, gear_ratio: 1/100}\n",
       "encoders.elbow.gear_ratio: 1/100 makes the encoder coarser"},
      {"filters: {velocity: {sample_rate: 1 kHz, lowpass: {family: first_order, cutoff: 50}}}\n",
       "filters.velocity has no 'derivative:' and estimates a position"},
      {"filters: {Joint_Acc: {derivative: 1, sample_rate: 1 kHz}}\n", "its name suggests 2"},
      {"configurations: {limits: {shoulder: [1, 1], lift: [0, 0], elbow: [1, 1]}}\n",
       "the range of every joint is empty"},
      {"sweep: [{key: encoders.elbow.bits, values: [13, 15]}]\n", "sweep: is not used"},
      {"requirements: [{quantity: position.x.sigma, statistic: max, at_most: 0.1}]\n",
       "requirements[0].at_most: 0.1 without a unit is in m, which is much"},
      {"threshold: {length: 300}\n", "threshold.length: 300 without a unit is in m"},
      {"effects: [{type: latency, joint: elbow, delay: 5}]\n", "effects[0].delay: 5 without a unit is in s"},
      {"motion: {sample_rate: 1 kHz, duration: 1 s, joints: {elbow: {sines: [{amplitude: 1 deg, frequency: "
       "1, phase: 30}]}}}\n",
       "motion.joints.elbow.sines[0].phase: 30 without a unit is in rad, 4.77 revolutions; degrees need "
       "their unit"},
  };
  for (const auto& c : cases) {
    const std::vector<std::string> warnings = read(spec_head + encoders + c.text).warnings;
    ASSERT_EQ(warnings.size(), 1u) << c.text;
    EXPECT_NE(warnings[0].find(c.warning), std::string::npos) << warnings[0];
  }
  EXPECT_TRUE(read(spec_head + encoders +
                   "filters: {velocity: {derivative: 1, sample_rate: 1 kHz}, speedy_x: "
                   "{derivative: 0, sample_rate: 1 kHz, lowpass: {family: first_order, cutoff: 9 rad/s}}}\n")
                  .warnings.empty());
}

TEST_F(ReadSpec, AFileThatIsNoTableIsRefusedWithoutItsContent) {
  for (const char* content :
       {"root:x:0:0:root:/root\n", "secret,words\n1,2\n", "\x80\x81 secret\n", "a\"b secret\n"}) {
    std::ofstream(folder_ / "points.csv") << content;
    const std::string message =
        refusal(spec_head + encoders + "configurations: {method: file, file: points.csv}\n");
    EXPECT_EQ(message.find("points.csv:1:"), 0u) << message;
    for (const char* part : {"root", "secret", "words"})
      EXPECT_EQ(message.find(part), std::string::npos) << message;
  }
}

TEST_F(ReadSpec, WarnsOfAnUnusedEncoder) {
  const Spec spec = read(spec_head + encoders + "  aside: {bits: 12}\n");
  ASSERT_EQ(spec.warnings.size(), 1u);
  EXPECT_NE(spec.warnings[0].find("encoders.aside is not used"), std::string::npos);
}

TEST_F(ReadSpec, ReadsPointsFromAFileInAnyColumnOrderAndUnit) {
  std::ofstream(folder_ / "points.csv")
      << "# poses\nelbow [deg],note,shoulder [rad],lift [mm]\n90,1,0.5,100\n-45,2,-0.5,0\n";
  const Spec spec = read(spec_head + encoders + "configurations: {method: file, file: points.csv}\n");
  ASSERT_EQ(spec.configurations.points.size(), 2u);
  EXPECT_DOUBLE_EQ(spec.configurations.points[0][2], std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(spec.configurations.points[0][1], 0.1);
  std::ofstream(folder_ / "points.csv") << "elbow,shoulder,lift\n0,0,0\n0,0\n";
  EXPECT_NE(refusal(spec_head + encoders + "configurations: {method: file, file: points.csv}\n")
                .find("points.csv:3:1: "),
            std::string::npos);
}

TEST_F(ReadSpec, AFileOfPointsMayHaveColumnsOfText) {
  std::ofstream(folder_ / "points.csv")
      << "elbow,note,shoulder,lift\r\n0,\"home, upright\",0.5,0\r\n\r\n1,,0,0\r\n";
  const Spec spec = read(spec_head + encoders + "configurations: {method: file, file: points.csv}\n");
  ASSERT_EQ(spec.configurations.points.size(), 2u);
  EXPECT_EQ(spec.configurations.points[0][0], 0.5);
  ASSERT_EQ(spec.warnings.size(), 1u);
  EXPECT_NE(spec.warnings[0].find("ignored"), std::string::npos);
  std::ofstream(folder_ / "points.csv") << "elbow,shoulder,lift\n0,0,0\n0,0,far\n";
  EXPECT_NE(refusal(spec_head + encoders + "configurations: {method: file, file: points.csv}\n")
                .find("points.csv:3:5: lift: not a finite decimal number, found 'far'"),
            std::string::npos);
}

TEST_F(ReadSpec, NoiseOfACoordinateMayBeAnAngleOrALength) {
  const auto with_noise = [&](const std::string& noise) {
    return spec_head + encoders +
           "filters: {k: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: kalman, process_noise: 10, "
           "measurement_noise: " +
           noise + "}}}\n";
  };
  const double gain = read(with_noise("5e-4")).filters[0].norms.h2;
  EXPECT_EQ(read(with_noise("0.5 mrad")).filters[0].norms.h2, gain);
  EXPECT_EQ(read(with_noise("0.5 mm")).filters[0].norms.h2, gain);
  EXPECT_NE(refusal(with_noise("0.5 kg")).find("give an angle or a length"), std::string::npos);
}

TEST_F(ReadSpec, AsksAboutNumbersInOtherUnits) {
  const auto warns = [&](const std::string& text, const std::string& of) {
    const std::vector<std::string> all = read(text).warnings;
    return std::any_of(all.begin(), all.end(),
                       [&](const auto& w) { return w.find(of) != std::string::npos; });
  };
  EXPECT_TRUE(warns(spec_head + "encoders: {'*': {counts_per_rev: 4.096}, lift: {resolution: 1.125 um}}\n",
                    "encoders.*.counts_per_rev: 4.096 has a decimal point"));
  EXPECT_FALSE(warns(spec_head + encoders, "decimal point") || warns(spec_head + encoders, "are these"));
  std::string in_degrees = arm;
  in_degrees.replace(in_degrees.find("upper=\"2\""), 9, "upper=\"90\"");
  std::ofstream(folder_ / "arm.urdf") << in_degrees;
  EXPECT_TRUE(warns(spec_head + encoders, "joint 'shoulder' has limits of [-2, 90] rad: are these degrees?"));
}

TEST_F(ReadSpec, ARobotMayHaveANameOfItsOwn) {
  EXPECT_EQ(read("qerr: 1\nrobot: {urdf: arm.urdf, tip: finger, name: cell 4}\n" + encoders).robot_name,
            "cell 4");
}

TEST_F(ReadSpec, ReadsTheSectionsOfLaterCommands) {
  const Spec spec = read(
      spec_head + encoders +
      "motion: {sample_rate: 1 kHz, duration: 15 s, joints: {elbow: {center: 10 deg, velocity: 1 deg/s, "
      "sines: [{amplitude: 15 deg, frequency: 2.5 Hz}]}, lift: {center: 0.1 m}}}\n"
      "effects: [{type: eccentricity, joint: elbow, amplitude: 0.4 mrad, phase: 30 deg}]\n"
      "sweep: [{key: encoders.elbow.bits, values: [13, 15]}, {key: threshold.length, from: 1 mm, to: 1 m, "
      "count: 4, scale: log}]\n");
  ASSERT_TRUE(spec.motion);
  EXPECT_DOUBLE_EQ(spec.motion->joints[2].sines[0].amplitude, std::numbers::pi / 12);
  EXPECT_EQ(spec.effects[0].numbers.at("amplitude"), 4e-4);
  EXPECT_EQ(spec.effects[0].choices.at("shaft"), "encoder");
  EXPECT_EQ(spec.sweep[1].steps.size(), 4u);
  EXPECT_EQ(spec.sweep[1].steps.front().names[0], "0.001 m");
  EXPECT_EQ(spec.sweep[1].steps.back().changes[0].second, "1 m");
}

TEST_F(ReadSpec, WholeStepsOfARangeAreWholeNumbers) {
  const Spec spec =
      read(spec_head + encoders + "sweep: [{key: encoders.elbow.bits, from: 1, to: 40, count: 40}]\n");
  for (int i = 0; i < 40; ++i)
    EXPECT_EQ(spec.sweep[0].steps[static_cast<std::size_t>(i)].names[0], std::to_string(i + 1));
}

}  // namespace
}  // namespace qerr
