#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "input/joint_entries.hpp"
#include "input/spec_variants.hpp"
#include "qerr/report/write.hpp"
#include "report/analysis/figures.hpp"
#include "support/random_spec.hpp"

// What an override changes, and what a requirement says, on random robots and specs.
namespace qerr {
namespace {

using testing::Dice;
using testing::RandomSpec;

/// A random spec in a folder of its own.
class SpecOnDisk {
 public:
  explicit SpecOnDisk(const RandomSpec& s) : SpecOnDisk(s.urdf({}), s.text({}, "robot.urdf")) {}
  /// @param spec  of `robot.urdf`
  SpecOnDisk(const std::string& urdf, std::string spec)
      : text(std::move(spec)),
        folder_(std::filesystem::temp_directory_path() / ("qerr_overrides_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "robot.urdf") << urdf;
  }
  ~SpecOnDisk() { std::filesystem::remove_all(folder_); }
  SpecOnDisk(const SpecOnDisk&) = delete;
  SpecOnDisk& operator=(const SpecOnDisk&) = delete;

  Spec read(const SpecOverrides& overrides = {}) const {
    return parse_spec(text, (folder_ / "spec.yaml").string(), overrides);
  }

  std::string text;

 private:
  std::filesystem::path folder_;
};

/// A spec of encoders by bits: the joints in `own` have entries of their own, the others the pattern '*'.
RandomSpec spec_of_bits(Dice& dice, std::vector<std::string>& own) {
  testing::ChainMix mix{2 + dice.below(6)};
  mix.prismatic = 0;
  RandomSpec s = testing::random_spec(dice);
  s.robot = testing::random_robot(dice, mix);
  s.encoders.clear();
  s.limits.clear();
  s.effects.clear();
  bool pattern = false;
  for (Joint& joint : s.robot.joints) {
    if (joint.type == JointType::fixed) continue;
    joint.limits = Limits{-2.5, 2};
    if (joint.mimic) continue;
    if (dice.chance(0.5))
      own.push_back(joint.name);
    else
      pattern = true;
  }
  for (const std::string& joint : own)
    s.encoders.push_back({joint, {{{"bits", {12 + static_cast<double>(dice.below(4))}}}, {}}});
  if (pattern) s.encoders.push_back({"'*'", {{{"bits", {16}}}, {}}});
  return s;
}

/// The pattern itself, a character of a name replaced by `?`, or its end by `*`.
std::string random_pattern(Dice& dice, const Chain& chain) {
  std::string name = chain.independent[dice.below(chain.independent.size())].name;
  if (dice.chance(0.3)) return "*";
  if (dice.chance(0.5))
    name[dice.below(name.size())] = '?';
  else
    name = name.substr(0, dice.below(name.size())) + '*';
  return name;
}

RC_GTEST_PROP(OverrideProperties, APatternChangesTheJointsThatItFitsAndNoOthers, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  std::vector<std::string> own;
  const SpecOnDisk disk(spec_of_bits(dice, own));
  const Spec before = disk.read();
  const std::string pattern = random_pattern(dice, before.model.chain);
  const Spec after = disk.read({{{"encoders." + pattern + ".bits", "20"}}, {}});
  for (std::size_t i = 0; i < before.model.chain.independent.size(); ++i) {
    const double was = before.model.transmission.encoders[i].resolution,
                 is = after.model.transmission.encoders[i].resolution;
    RC_ASSERT(is ==
              (fits(pattern, before.model.chain.independent[i].name) ? 2 * std::numbers::pi / 0x1p20 : was));
  }
}

RC_GTEST_PROP(OverrideProperties, ANameThatBeatsALaterPatternIsTold, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  std::vector<std::string> own;
  const SpecOnDisk disk(spec_of_bits(dice, own));
  const Chain chain = disk.read().model.chain;
  RC_PRE(chain.independent.size() > 1);
  const std::string joint = chain.independent[dice.below(chain.independent.size())].name;
  const std::pair<std::string, std::string> name{"encoders." + joint + ".bits", "20"},
      pattern{"encoders.*.bits", "8"};
  const bool name_first = dice.chance(0.5);
  const Spec spec = disk.read({name_first ? std::vector{name, pattern} : std::vector{pattern, name}, {}});
  RC_ASSERT(spec.model.transmission.encoders[independent_index(chain, joint)].resolution ==
            2 * std::numbers::pi / 0x1p20);
  const bool told = std::any_of(spec.warnings.begin(), spec.warnings.end(), [](const std::string& w) {
    return w.find("a name beats a pattern") != std::string::npos;
  });
  RC_ASSERT(told == name_first);
}

/// An override of a random key with a random value.
std::pair<std::string, std::string> random_override(Dice& dice, const RandomSpec& s) {
  const std::string joint = s.encoders[dice.below(s.encoders.size())].first;
  std::vector<std::pair<std::string, std::string>> all{
      {"encoders." + joint + ".accuracy", "1e-4"},
      {"encoders." + joint + ".rounding", dice.chance(0.5) ? "down" : "nearest"},
      {"encoders." + joint + ".zero", "free"},
      {"encoders." + joint + ".resolution", "3e-4"},
      {"encoders.*.accuracy", "2e-5"},
      {"configurations.count", std::to_string(1 + dice.below(60))},
      {"configurations.seed", std::to_string(dice.below(3))},
      {"configurations.method", dice.chance(0.5) ? "grid" : "random"},
      {"configurations.limits." + joint, "[-0.1, 0.2]"},
      {"filters.velocity.lowpass.cutoff", "77"},
      {"filters.velocity.lowpass.order", std::to_string(1 + dice.below(4))},
      {"filters.velocity.sample_rate", "2 kHz"},
      {"filters.velocity.derivative", "2"},
      {"coordinates", "[z]"},
      {"frame", dice.chance(0.5) ? "tip" : "base"},
      {"robot.tool.xyz", "[0, 0.1, 0]"},
      {"robot.tool.rpy", "[0, 0, 1]"},
      {"threshold.length", "0.3"},
      {"requirements", "[{quantity: position.x.sigma, statistic: max, at_most: 1}]"},
      {"sweep", "[{key: configurations.count, values: [1, 2]}]"},
      {"motion", "{sample_rate: 100, duration: 1, joints: {" + joint + ": {velocity: 0.1}}}"}};
  if (!s.effects.empty()) all.push_back({"effects.0." + s.effects[0].numbers[0].first, "2e-4"});
  return all[dice.below(all.size())];
}

std::string report_of(Spec spec) {
  spec.overrides.clear();
  return write(analyze(spec, {.threads = 1}), "json");
}

// The report of `analyze` changes, or a warning or an error says that it does not.
RC_GTEST_PROP(OverrideProperties, AnOverrideChangesTheReportOrIsSaidToChangeNothing, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  const RandomSpec s = testing::random_spec(dice);
  const SpecOnDisk disk(s);
  const auto [key, value] = random_override(dice, s);
  const SpecOverrides set{{{key, value}}, {}};
  const std::string before = report_of(disk.read());
  try {
    const Spec spec = disk.read(set);
    const auto idle = idle_overrides(spec, set, {"requirements", "threshold", "sweep", "design"},
                                     [](const Spec& some) { return figures_of_some(some, 1); });
    const auto written = [&](const char* given) { return disk.text.find(given) != std::string::npos; };
    const bool changed = report_of(spec) != before;
    const bool said = idle.size() == 1 && idle[0].starts_with("--set " + key);
    const bool repeats = written((key.substr(key.rfind('.') + 1) + ": " + value).c_str());
    RC_TAG(changed ? "changed" : said ? "said" : "repeats");
    RC_LOG() << key << '=' << value << '\n' << disk.text;
    RC_ASSERT(changed || said || repeats);
    // Sections that `analyze` does not use may bring warnings of their own.
    RC_ASSERT(idle.empty() || !changed || key == "sweep" || key == "requirements");
  } catch (const Error& e) {
    RC_TAG("refused");
    RC_ASSERT(e.trouble() == Trouble::input);
  }
}

/// Whether small rotations and travels of the joints move a position coordinate anywhere, by central
/// differences of the forward kinematics.
bool moves(Dice& dice, const Spec& spec, Eigen::Index coordinate) {
  constexpr double step = 1e-4, least = 1e-6;
  const Chain& chain = spec.model.chain;
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::VectorXd q = testing::random_configuration(dice, chain);
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      Eigen::VectorXd above = q, below = q;
      above[i] += step;
      below[i] -= step;
      Eigen::Vector3d d =
          (forward_kinematics(chain, above).translation() - forward_kinematics(chain, below).translation()) /
          (2 * step);
      if (spec.model.frame == CoordinateFrame::tip) d = forward_kinematics(chain, q).linear().transpose() * d;
      if (std::abs(d[coordinate]) > least) return true;
    }
  }
  return false;
}

/// A planar arm whose axes are turned out of the plane's normal and back by right angles.
/// @param digits  of pi/2 behind the point
std::string planar_arm(int digits, double elbow) {
  const double right = std::round(std::numbers::pi / 2 * std::pow(10, digits)) / std::pow(10, digits);
  const auto joint = [](const std::string& type, int k, double roll, double yaw) {
    return "<joint name='" + type + std::to_string(k) + "' type='" + type + "'><parent link='l" +
           std::to_string(k) + "'/><child link='l" + std::to_string(k + 1) +
           "'/><origin xyz='0.3 0 0' rpy='" + std::to_string(roll) + " 0 " + std::to_string(yaw) +
           "'/><axis xyz='0 1 0'/><limit lower='-2' upper='2' effort='1' velocity='1'/></joint>";
  };
  std::string text = "<robot name='planar'>";
  for (int k = 0; k < 5; ++k) text += "<link name='l" + std::to_string(k) + "'/>";
  return text + joint("fixed", 0, right, 0) + joint("revolute", 1, 0, 0) + joint("revolute", 2, 0, elbow) +
         joint("fixed", 3, right, 0) + "</robot>";
}

TEST(RequirementProperties, RoundedRightAnglesLetNoErrorReachAQuantity) {
  const auto verdict = [](int digits, double elbow, char coordinate) {
    SpecOnDisk disk(planar_arm(digits, elbow),
                    "qerr: 1\nrobot: {urdf: robot.urdf}\nencoders: {'*': {bits: 12}}\n");
    disk.text += std::string("requirements: [{quantity: position.") + coordinate +
                 ".worst_case, statistic: max, at_most: 1 mm}]\n";
    const SpecCheck check = evaluate(disk.read(), {.threads = 1});
    std::string warnings;
    for (const std::string& w : check.analysis.warnings) warnings += w;
    return warnings;
  };
  const auto refused = [&](int digits, double elbow, char coordinate) {
    try {
      verdict(digits, elbow, coordinate);
      return std::string();
    } catch (const Error& e) {
      return std::string(e.what());
    }
  };
  constexpr double none = 0, tilted = 0.3;
  for (int digits = 4; digits <= 6; ++digits) {
    EXPECT_NE(refused(digits, none, 'z').find("only the rounding of the URDF's angles"), std::string::npos)
        << digits << refused(digits, none, 'z');
    EXPECT_EQ(verdict(digits, none, 'x').find("angles"), std::string::npos);
    EXPECT_EQ(verdict(digits, tilted, 'z').find("angles"), std::string::npos);
  }
  EXPECT_NE(verdict(2, none, 'z').find("right angles to 2 mrad"), std::string::npos);
}

RC_GTEST_PROP(RequirementProperties, AVerdictIsGivenWhereAnErrorReachesTheQuantityAndNowhereElse, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  RandomSpec s = testing::random_spec(dice);
  s.coordinates = "[x, y, z]";
  s.count = 40;
  SpecOnDisk disk(s);
  const Eigen::Index coordinate = static_cast<Eigen::Index>(dice.below(3));
  const bool filtered = dice.chance(0.5);
  const char* const bounds[] = {"worst_case", "worst_case_rigorous"};
  disk.text += std::string("requirements: [{quantity: ") + (filtered ? "velocity." : "position.") +
               "xyz"[coordinate] + '.' + bounds[filtered ? 0 : dice.below(2)] +
               ", statistic: p50, at_most: 1}]\n";
  const Spec spec = disk.read();
  const bool reached = moves(dice, spec, coordinate);
  RC_TAG(reached ? "reached" : "not reached");
  try {
    requirement_results(analyze(spec, {.threads = 1}));
    RC_ASSERT(reached);
  } catch (const Error& e) {
    RC_ASSERT(std::string(e.what()).find("no error reaches") != std::string::npos);
    RC_ASSERT(!reached);
  }
}

}  // namespace
}  // namespace qerr
