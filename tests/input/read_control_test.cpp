#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "control/control.hpp"
#include "qerr/kinematics/chain.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"
#include "report/analysis/figures.hpp"

namespace qerr {
namespace {

class ControlSection : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("qerr_control_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "arm.urdf")
        << R"(<robot name="arm"><link name="a"/><link name="b"/><link name="c"/>
      <joint name="j1" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
        <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
      <joint name="j2" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>)";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Spec read(const std::string& sections, const SpecOverrides& overrides = {}) {
    return parse_spec(
        "qerr: 1\nrobot: {urdf: arm.urdf, tool: {xyz: [0.4, 0, 0]}}\n"
        "encoders: {j1: {resolution: 1 mrad}, j2: {resolution: 2 mrad, rounding: down}}\n"
        "configurations: {method: list, points: [[0.3, 0.7]]}\n"
        "filters:\n"
        "  v: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: butterworth, order: 2, cutoff: 30 "
        "Hz}}\n" +
            sections,
        (folder_ / "spec.yaml").string(), overrides);
  }
  Spec controlled(const std::string& more = "", const SpecOverrides& overrides = {}) {
    return read(
        "control: {joints: {'j*': {kp: 400 N m/rad, kd: 5 N m s/rad, velocity: v, inertia: 0.6 kg m^2,\n"
        "  damping: 0.2, friction: 0.4}}}\n" +
            more,
        overrides);
  }
  std::string refusal(const std::string& sections) {
    try {
      check(read(sections));
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  }
  double required(const Spec& spec) { return check(spec).results.front().value; }

  std::filesystem::path folder_;
};

/// sum |k + d h|, its squares and its sum, by the impulse response.
struct FilterSums {
  double l1 = 0, h2 = 0, dc = 0;
};

FilterSums filter_sums(const Filter& h, double k, double d) {
  FilterSums s;
  std::vector<double> response = impulse_response(h, 4000);
  for (double& x : response) x *= d;
  response[0] += k;
  for (const double x : response) s.l1 += std::abs(x), s.h2 += x * x, s.dc += x;
  s.h2 = std::sqrt(s.h2);
  return s;
}

TEST_F(ControlSection, TorqueIsThatOfTheImpulseResponse) {
  const Spec spec = controlled("coupling: [[1, 0], [0.5, 1]]\n");
  const FilterSums f = filter_sums(spec.filters[0].filter, 400, 5);
  const auto torque = [&](const std::string& quantity, const std::string& statistic = ", statistic: max") {
    return required(controlled("coupling: [[1, 0], [0.5, 1]]\nrequirements: [{quantity: " + quantity +
                               statistic + ", at_most: 1e9}]\n"));
  };
  EXPECT_NEAR(torque("torque.j1.worst_case"), f.l1 * 0.5e-3, 1e-11);
  EXPECT_NEAR(torque("torque.j2.worst_case"), f.l1 * (0.25e-3 + 1e-3) + std::abs(f.dc) * 1e-3, 1e-11);
  EXPECT_NEAR(torque("torque.j2.sigma"), f.h2 * std::hypot(0.5e-3, 2e-3) / std::sqrt(12), 1e-11);
  EXPECT_NEAR(torque("torque.j1.l1_norm", ""), f.l1, 1e-8);
}

TEST_F(ControlSection, FiltersOfJointsHaveFiguresOfTheseJointsOnly) {
  const Spec spec = read("  w: {joints: 'j2', derivative: 1, sample_rate: 1 kHz}\n");
  std::string names;
  for (const FigureName& f : all_figures(spec)) names += f.quantity() + ' ';
  EXPECT_NE(names.find("w.j2.sigma "), std::string::npos);
  EXPECT_NE(names.find("v.j2.sigma "), std::string::npos);
  EXPECT_EQ(names.find("w.x."), std::string::npos);
  EXPECT_EQ(names.find("w.j1."), std::string::npos);
  EXPECT_NE(refusal("  w: {joints: 'j2', derivative: 1, sample_rate: 1 kHz}\n"
                    "requirements: [{quantity: w.x.sigma, statistic: max, at_most: 1}]\n")
                .find("does not filter 'x'"),
            std::string::npos);
  EXPECT_NE(refusal("  w: {joints: 'k*', derivative: 1, sample_rate: 1 kHz}\n").find("fits no joint"),
            std::string::npos);
}

TEST_F(ControlSection, OverridesChangeOneJointAndKeepWhatItsPatternSays) {
  const Spec spec = controlled("", {{{"control.joints.j1.kp", "800"}}, {}});
  EXPECT_EQ(spec.model.control->joints[0].kp, 800);
  EXPECT_EQ(spec.model.control->joints[0].kd, 5);
  EXPECT_EQ(spec.model.control->joints[1].kp, 400);
}

TEST_F(ControlSection, ImpedanceAtTheTipIsOneFilterForEachPairOfJoints) {
  const Spec spec =
      read("control: {tip: {stiffness: [2 kN/m, 1 kN/m, 1 kN/m], damping: [20, 30, 0], velocity: v}}\n");
  const Analysis a = analyze(spec);
  const Eigen::MatrixXd j = jacobian(spec.model.chain, Eigen::Vector2d(0.3, 0.7)).topRows<3>();
  const Eigen::MatrixXd k = j.transpose() * Eigen::Vector3d(2000, 1000, 1000).asDiagonal() * j,
                        d = j.transpose() * Eigen::Vector3d(20, 30, 0).asDiagonal() * j;
  const std::vector<Signal> all = all_signals(spec.model);
  for (Eigen::Index i = 0; i < 2; ++i) {
    const FilterSums first = filter_sums(spec.filters[0].filter, k(i, 0), d(i, 0)),
                     second = filter_sums(spec.filters[0].filter, k(i, 1), d(i, 1));
    bool found = false;
    for (std::size_t s = 0; s < all.size(); ++s) {
      if (all[s].name != "torque.j" + std::to_string(i + 1)) continue;
      found = true;
      EXPECT_NEAR(a.workspace.coordinates[s].worst_case.max,
                  first.l1 * 0.5e-3 + second.l1 * 1e-3 + std::abs(second.dc) * 1e-3, 1e-9);
      EXPECT_NEAR(a.workspace.coordinates[s].sigma.max,
                  std::hypot(first.h2 * 1e-3, second.h2 * 2e-3) / std::sqrt(12), 1e-9);
    }
    EXPECT_TRUE(found);
  }
}

TEST_F(ControlSection, LargestGainJustMeetsTheRequirement) {
  const std::string limit =
      "requirements: [{quantity: torque.j2.worst_case, statistic: max, at_most: 2.5}]\n";
  const Spec spec = controlled(limit);
  const ControlReport report = control_report(spec);
  ASSERT_EQ(report.gains.size(), 1u);
  const double kd = report.gains.front().kd;
  const Spec with = controlled(limit, {{{"control.joints.j2.kd", std::to_string(kd)}}, {}});
  EXPECT_NEAR(required(with), 2.5, 1e-5);
}

TEST_F(ControlSection, AnUnstableLoopMeetsNoRequirement) {
  const std::string fast = "control: {joints: {'*': {kp: 4000, kd: 900, velocity: v, inertia: 0.6}}}\n";
  for (const std::string quantity :
       {"loop.j1.limit_cycle, at_most: 1e9", "loop.j1.bandwidth, at_least: 0",
        "loop.j1.phase_margin, at_least: 0", "loop.j1.gain_margin, at_least: 1",
        "loop.j1.gain_margin, at_least: 0", "loop.j1.gain_margin, at_most: 1e9",
        "loop.j1.limit_cycle, at_least: 1e-9", "closed_torque.j1.sigma, statistic: max, at_least: 1e-9",
        "closed_torque.j1.sigma, statistic: max, at_most: 1e9"})
    EXPECT_FALSE(check(read(fast + "requirements: [{quantity: " + quantity + "}]\n")).all_met()) << quantity;
  const Analysis a = analyze(read(fast));
  bool told = false;
  for (const std::string& warning : a.warnings) told = told || warning.find("unstable") != std::string::npos;
  EXPECT_TRUE(told);
}

TEST_F(ControlSection, LoopsAreThoseOfTheDelayedOrMultipliedReading) {
  const auto loop = [&](const std::string& more, const SpecOverrides& changed = {}) {
    const Analysis a = analyze(controlled(more, changed));
    return a.control->loops.front();
  };
  const auto gain = [](const WorstLoop& l) { return l.margins.gain; };
  const double alone = gain(loop(""));
  EXPECT_LT(gain(loop("effects: [{type: latency, joint: j1, delay: 0.3 ms}]\n")), alone);
  EXPECT_DOUBLE_EQ(gain(loop("effects: [{type: latency, joint: j1, delay: 0.3 ms}]\n")),
                   gain(loop("", {{{"control.delay", "1.3 ms"}}, {}})));
  EXPECT_NEAR(gain(loop("effects: [{type: scale, joint: j1, scale: 0.25}]\n")), alone / 1.25, 1e-9 * alone);
  EXPECT_DOUBLE_EQ(gain(loop("effects: [{type: latency, joint: j2, delay: 2 ms}]\n")), alone)
      << "of the other";
  EXPECT_FALSE(loop("effects: [{type: decoding, joint: j1, factor: -1}]\n").stable);
  EXPECT_THROW(controlled("effects: [{type: latency, joint: j1, delay: -2 ms}]\n"), Error) << "of the future";
  EXPECT_THROW(controlled("effects: [{type: scale, joint: j1, scale: -1}]\n"), Error) << "reads nothing";
}

TEST_F(ControlSection, PlayAndUnequalStatesLastAtRest) {
  const auto cycle = [&](const std::string& more) {
    return analyze(controlled(more)).control->loops.front().cycle;
  };
  const LimitCycle alone = cycle(""), play = cycle("effects: [{type: backlash, joint: j1, gap: 1 mrad}]\n");
  EXPECT_NEAR(play.bound, 2 * alone.bound, 1e-9 * play.bound) << "of a count of 1 mrad";
  ASSERT_TRUE(play.play);
  EXPECT_GT(play.bound, play.play->amplitude);
  EXPECT_FALSE(alone.play);
  const std::string wall = "walls: {w: {normal: [1, 0, 0]}}\n";
  const auto limit = [&](const std::string& more) {
    return analyze(controlled(wall + more)).control->walls.front().quantization;
  };
  EXPECT_LT(limit("effects: [{type: backlash, joint: j1, gap: 1 mrad}]\n"), limit(""));
  const std::string scale = "effects: [{type: scale, joint: j1, scale: 0.1}]\n",
                    required = "requirements: [{quantity: wall.w.stiffness, at_least: 1}]\n";
  EXPECT_THROW(check(controlled(wall + scale + required)), Error) << "not counted in a wall";
}

TEST_F(ControlSection, ErrorsThatDependOnThePositionChangeTheGainOfALoop) {
  const auto loop = [&](const std::string& more) { return analyze(controlled(more)).control->loops.front(); };
  const WorstLoop alone = loop(""),
                  periodic = loop("effects: [{type: eccentricity, joint: j1, amplitude: 0.02}]\n");
  EXPECT_NEAR(periodic.margins.gain * 1.02, alone.margins.gain, 1e-4 * alone.margins.gain);  // slope 0.02
  EXPECT_GT(periodic.cycle.bound, 1.02 * alone.cycle.bound);
  EXPECT_LT(periodic.cycle.bound, 1.2 * alone.cycle.bound) << "by the slope, not by the amplitude";
  const double more = alone.margins.gain;  // of a slope beyond it
  EXPECT_FALSE(
      loop("effects: [{type: eccentricity, joint: j1, amplitude: " + std::to_string(more) + "}]\n").stable);
}

TEST_F(ControlSection, AFactorMultipliesWhatStandsBeforeIt) {
  // Of a reading f (x + e) the error is f e, and beside the same loop the motion that of e.
  const auto bound = [&](const std::string& effects) {
    return analyze(controlled("effects: [" + effects + "]\n")).control->loops.front().cycle.bound;
  };
  const std::string play = "{type: backlash, joint: j1, gap: 1 rad}",
                    scale = "{type: scale, joint: j1, scale: ";
  const double doubled = bound(scale + "0.5}, " + play), counts = bound(scale + "0.5}");
  const double alone = bound(play), without = bound("");
  const double norm = without / 5e-4, norm_of_scaled = counts / 5e-4;  // of half a count
  EXPECT_NEAR(alone - without, norm * 0.5, 1e-9 * alone);
  EXPECT_NEAR(doubled - counts, norm_of_scaled * 1.5 * 0.5, 1e-9 * doubled);
}

TEST_F(ControlSection, TheFrictionThatEndsACycleIsTheControllersNormPlusItsGain) {
  const Spec spec = controlled();
  const double norm = filter_sums(spec.filters[0].filter, 400, 5).l1, half_count = 5e-4;
  EXPECT_NEAR(analyze(spec).control->loops.front().cycle.ending_friction, (norm + 400) * half_count,
              1e-9 * norm * half_count);
}

TEST_F(ControlSection, ATipOfSeveralMovesAsTheOnlyOne) {
  const std::string
      robot = "robot: {urdf: arm.urdf, ",
      rest =
          "encoders: {'*': {resolution: 1 mrad}}\n"
          "control: {sample_rate: 1 kHz, joints: {'*': {kp: 400, kd: 0, inertia: 0.6, damping: 20}}}\n"
          "configurations: {method: list, points: [[0.3, 0.7]]}\n";
  const auto largest = [&](const std::string& tip, const std::string& signal) {
    return required(parse_spec("qerr: 1\n" + robot + tip + "}\n" + rest +
                                   "requirements: [{quantity: closed_position." + signal +
                                   ".worst_case, statistic: max, at_most: 1}]\n",
                               (folder_ / "tips.yaml").string()));
  };
  for (const char* axis : {"x", "y"})
    EXPECT_DOUBLE_EQ(largest("tips: {hand: c, elbow: b}", std::string("hand.") + axis),
                     largest("tip: c", axis));
  EXPECT_THROW(largest("tip: c", "xyz"), Error);
}

TEST_F(ControlSection, AWallThatNoJointFeelsIsNoRequirement) {
  const std::string required = "requirements: [{quantity: wall.w.stiffness, at_least: 1}]\n";
  EXPECT_TRUE(check(controlled("walls: {w: {normal: [1, 0, 0]}}\n" + required)).all_met());
  EXPECT_THROW(check(controlled("walls: {w: {normal: [0, 0, 1]}}\n" + required)), Error);
}

TEST_F(ControlSection, LoopsAndWallsAreComparedWithABaseline) {
  const std::string wall = "walls: {w: {normal: [1, 0, 0]}}\n";
  const Baseline before{read_named_figures(write(analyze(controlled(wall)), "json"), "old.json"), 0};
  const auto worse = [&](const Spec& spec, const std::string& figure) {
    const SpecCheck c = check(spec, {}, &before);
    return std::any_of(c.baseline->regressions.begin(), c.baseline->regressions.end(),
                       [&](const FigureChange& f) { return f.figure.quantity == figure; });
  };
  const Spec late = controlled(wall, {{{"control.delay", "3 ms"}}, {}});
  for (const char* figure :
       {"loop.j1.gain_margin", "loop.j1.phase_margin", "loop.j1.limit_cycle", "wall.w.stiffness"}) {
    EXPECT_TRUE(worse(late, figure)) << figure;
    EXPECT_FALSE(worse(controlled(wall), figure)) << figure;
  }
}

TEST_F(ControlSection, RefusesWhatCannotBe) {
  const auto of_joints = [&](const std::string& entry) {
    return refusal("control: {joints: {'*': {" + entry + "}}}\n");
  };
  EXPECT_NE(of_joints("kp: 1, kd: 1").find("needs the filter"), std::string::npos);
  EXPECT_NE(of_joints("kp: 1, kd: 1, velocity: w").find("no such filter"), std::string::npos);
  EXPECT_NE(of_joints("kp: 1 kN/m, kd: 1, velocity: v").find("kp"), std::string::npos);
  EXPECT_NE(of_joints("kp: 1, stiffness: 2").find("stiffness"), std::string::npos);
  EXPECT_NE(of_joints("kp: 1").find("sample_rate"), std::string::npos);
  EXPECT_NE(
      refusal("control: {sample_rate: 2 kHz, joints: {'*': {kd: 1, velocity: v}}}\n").find("one sample rate"),
      std::string::npos);
  EXPECT_NE(refusal("control: {delay: 1 s, joints: {'*': {kd: 1, velocity: v}}}\n").find("64 samples"),
            std::string::npos);
  EXPECT_NE(refusal("walls: {w: {normal: [0, 0, 1]}}\n").find("walls need"), std::string::npos);
  EXPECT_NE(
      refusal(
          "control: {joints: {'*': {kd: 1, velocity: v}}}\nrequirements: [{quantity: loop.j1.gain_margin, "
          "at_least: 2}]\n")
          .find("no such figure"),
      std::string::npos)
      << "without an inertia there is no loop";
}

TEST_F(ControlSection, FiguresAreRowsOfCsv) {
  const std::string sections = "walls: {floor: {normal: [1, 0, 0]}}\n",
                    limits = "requirements: [{quantity: torque.j1.worst_case, statistic: max, at_most: 9}]\n";
  const std::vector<SingleFigure> rows = single_figures(analyze(controlled(sections + limits), {}));
  const auto row = [&](const std::string& quantity) {
    const auto found =
        std::find_if(rows.begin(), rows.end(), [&](const SingleFigure& f) { return f.quantity == quantity; });
    return found == rows.end() ? -1 : found->value;
  };
  for (const std::string quantity : {"loop.j1.gain_margin", "loop.j2.phase_margin", "loop.j1.bandwidth",
                                     "loop.j2.limit_cycle", "wall.floor.stiffness", "control.j1.kd_max"})
    EXPECT_EQ(row(quantity),
              required(controlled(sections + "requirements: [{quantity: " + quantity +
                                  ", at_least: 0.1}, {quantity: torque.j1.worst_case, statistic: max, "
                                  "at_most: 9}]\n")))
        << quantity;
  EXPECT_EQ(row("control.j2.kd_max"), -1) << "there is no requirement on its torque";
  const std::string csv = write(analyze(controlled(sections), {}), "csv");
  EXPECT_NE(csv.find("\r\nloop,,j1,,gain_margin,min,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("\r\nloop,,j2,rad,limit_cycle,max,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("\r\nwall,,floor,N/m,stiffness,min,"), std::string::npos) << csv;
}

TEST_F(ControlSection, RowsOfUncountedReadingsAreEmpty) {
  const std::string coupled = "coupling: [[1, 0], [-1, 1]]\n",
                    late = "effects: [{type: latency, joint: j2, delay: 1 ms}]\n";
  const auto csv = [&](const std::string& more) { return write(analyze(controlled(more), {}), "csv"); };
  EXPECT_EQ(csv(coupled).find("loop,,j2,,gain_margin,min,\r\n"), std::string::npos) << csv(coupled);
  EXPECT_NE(csv(coupled + late).find("loop,,j2,,gain_margin,min,\r\n"), std::string::npos)
      << csv(coupled + late);
}

TEST_F(ControlSection, AGainOfZeroNeedsNoEditAndItsUnstableLoopIsUnbounded) {
  SpecOverrides overrides;
  overrides.values = {{"control.joints.j1.kd", "0"}, {"control.joints.j1.damping", "0"}};
  const std::string csv = write(analyze(controlled("", overrides), {}), "csv");
  EXPECT_NE(csv.find("loop,,j1,rad,limit_cycle,max,inf\r\n"), std::string::npos) << csv;
  EXPECT_NE(csv.find("loop,,j1,,gain_margin,min,\r\n"), std::string::npos) << csv;
}

}  // namespace
}  // namespace qerr
