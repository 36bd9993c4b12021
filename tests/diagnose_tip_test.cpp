#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "qerr/core/random.hpp"
#include "qerr/diagnose/diagnosis.hpp"
#include "random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

/// A rotation by Rodrigues' formula, written out: nothing of the library's kinematics is used here.
Eigen::Matrix3d rotation(const Eigen::Vector3d& z, double angle) {
  Eigen::Matrix3d k;
  k << 0, -z.z(), z.y(), z.z(), 0, -z.x(), -z.y(), z.x(), 0;
  return Eigen::Matrix3d::Identity() + std::sin(angle) * k + (1 - std::cos(angle)) * k * k;
}

/// An open chain of revolute joints: where each joint sits in the link before, and its axis there.
struct Arm {
  std::vector<Eigen::Vector3d> place, axis;
  Eigen::Vector3d tool;

  std::size_t size() const { return place.size(); }

  Eigen::Vector3d tip(const Eigen::VectorXd& q) const {
    Eigen::Vector3d p = tool;
    for (std::size_t i = size(); i-- > 0;)
      p = place[i] + rotation(axis[i], q[static_cast<Eigen::Index>(i)]) * p;
    return p;
  }

  OperationalModel model(const std::vector<double>& resolution) const {
    OperationalModel m;
    m.chain.base = "base";
    m.chain.tip = "tip";
    const auto n = static_cast<Eigen::Index>(size());
    m.transmission.coupling = Eigen::MatrixXd::Identity(n, n);
    for (std::size_t i = 0; i < size(); ++i) {
      ChainJoint joint;
      joint.name = "j" + std::to_string(i + 1);
      joint.origin.translate(place[i]);
      joint.axis = axis[i];
      joint.coordinate = i;
      m.chain.joints.push_back(joint);
      m.chain.independent.push_back({joint.name, JointType::revolute, {}});
      m.transmission.encoders.push_back({resolution[i], Rounding::nearest, true, 1});
    }
    m.chain.tip_offset.translate(tool);
    m.coordinates = {Coordinate::x, Coordinate::y, Coordinate::z};
    return m;
  }
};

/// Axes by turns about z, y, y, x, y, x and somewhat askew, links of a few decimetres across and along them.
Arm random_arm(Dice& dice, std::size_t joints) {
  const std::array<Eigen::Vector3d, 6> usual{Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(),
                                             Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX(),
                                             Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX()};
  Arm arm;
  for (std::size_t i = 0; i < joints; ++i) {
    arm.axis.push_back((usual[i] + 0.1 * dice.direction()).normalized());
    arm.place.emplace_back(dice.between(0.05, 0.4), dice.between(-0.1, 0.1), dice.between(0.05, 0.4));
  }
  arm.tool = {dice.between(0.1, 0.3), dice.between(-0.1, 0.1), dice.between(0.05, 0.2)};
  return arm;
}

double gaussian(Dice& dice) {
  return std::sqrt(-2 * std::log(dice.between(1e-12, 1))) *
         std::cos(2 * std::numbers::pi * dice.between(0, 1));
}

/// What is recorded: true joint angles, and what the encoders see of them.
struct Record {
  Eigen::ArrayXd time;        ///< empty: a table
  Eigen::MatrixXd joints;     ///< true, joints x rows
  Eigen::MatrixXd additions;  ///< of the flaws to what the encoders see
  bool with_references = false;
};

/// Poses all over the joints' ranges, in no order.
Record poses(Dice& dice, std::size_t joints, Eigen::Index rows) {
  Record r;
  r.joints.resize(static_cast<Eigen::Index>(joints), rows);
  for (double& q : r.joints.reshaped()) q = dice.between(-1.5, 1.5);
  r.additions.setZero(r.joints.rows(), rows);
  return r;
}

/// Sums of sines of a few tenths of a radian, many counts per sample.
Record motion(Dice& dice, std::size_t joints, Eigen::Index rows) {
  Record r;
  r.time = Eigen::ArrayXd::LinSpaced(rows, 0, 0.01 * static_cast<double>(rows - 1));
  r.joints.setZero(static_cast<Eigen::Index>(joints), rows);
  for (Eigen::Index j = 0; j < r.joints.rows(); ++j) {
    r.joints.row(j).setConstant(dice.between(-0.5, 0.5));
    for (int i = 0; i < 3; ++i)
      r.joints.row(j) +=
          (dice.between(0.2, 0.6) *
           (2 * std::numbers::pi * dice.between(0.05, 0.4) * r.time + dice.between(0, 6.28)).sin())
              .matrix()
              .transpose();
  }
  r.additions.setZero(r.joints.rows(), rows);
  return r;
}

LogColumn column(LogSignal signal, std::size_t index, int decimals) {
  LogColumn c;
  c.signal = signal;
  c.index = index;
  c.text = {decimals, decimals, 12};
  return c;
}

/// The log of the arm as it was built; `seen` is what the tracker makes of the tip.
Log log_of(
    Dice& dice, const Arm& built, const Record& r, const std::vector<double>& resolution,
    double tracker_noise,
    const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& seen = [](const Eigen::Vector3d& p) {
      return p;
    }) {
  Log log;
  const Eigen::Index rows = r.joints.cols(), joints = r.joints.rows();
  if (r.time.size() > 0) log.columns.push_back(column(LogSignal::time, 0, 3));
  for (Eigen::Index j = 0; j < joints; ++j)
    log.columns.push_back(column(LogSignal::counts, static_cast<std::size_t>(j), 0));
  if (r.with_references)
    for (Eigen::Index j = 0; j < joints; ++j)
      log.columns.push_back(column(LogSignal::reference, static_cast<std::size_t>(j), 9));
  for (std::size_t i = 0; i < 3; ++i) log.columns.push_back(column(LogSignal::tip, i, 9));
  log.rows = static_cast<std::uint64_t>(rows);
  log.values.resize(rows, static_cast<Eigen::Index>(log.columns.size()));
  for (Eigen::Index k = 0; k < rows; ++k) {
    Eigen::Index at = 0;
    if (r.time.size() > 0) log.values(k, at++) = r.time[k];
    for (Eigen::Index j = 0; j < joints; ++j)
      log.values(k, at++) =
          std::floor((r.joints(j, k) + r.additions(j, k)) / resolution[static_cast<std::size_t>(j)] + 0.5);
    if (r.with_references)
      for (Eigen::Index j = 0; j < joints; ++j)
        log.values(k, at++) =
            r.joints(j, k) + 0.05 * resolution[static_cast<std::size_t>(j)] * gaussian(dice);
    const Eigen::Vector3d tip = seen(built.tip(r.joints.col(k)));
    for (Eigen::Index i = 0; i < 3; ++i) log.values(k, at++) = tip[i] + tracker_noise * gaussian(dice);
  }
  return log;
}

Diagnosis judge(const OperationalModel& model, const Log& log) { return diagnose(model, {}, {}, log); }

bool tells(const Diagnosis& d, const std::string& effect, const std::string& joint) {
  return std::any_of(d.causes.begin(), d.causes.end(),
                     [&](const Cause& c) { return c.effect.type == effect && c.effect.joint == joint; }) ||
         std::any_of(d.alternatives.begin(), d.alternatives.end(),
                     [&](const AlternativeCause& a) { return a.effect == effect && a.joint == joint; });
}

std::string told(const Diagnosis& d) {
  std::string text(name(d.verdict));
  for (const Cause& c : d.causes) text += ", " + c.effect.type + " at " + c.effect.joint;
  for (const AlternativeCause& a : d.alternatives) text += ", or " + a.effect + " at " + a.joint;
  for (const Unnamed& u : d.unexplained) text += ", unexplained at " + u.joint + ": " + u.what;
  return text;
}

TEST(DiagnoseTip, NamesTheJointThatSitsElsewhereAndByHowMuch) {
  int inside = 0, intervals = 0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    Dice dice(seed);
    const std::size_t joints = 2 + dice.below(5);
    const Arm arm = random_arm(dice, joints);
    const std::vector<double> resolution(joints, 1e-4);
    Arm built = arm;
    const std::size_t at = dice.below(joints);
    const auto axis = static_cast<Eigen::Index>(dice.below(3));
    const double length = (dice.chance(0.5) ? 1 : -1) * dice.between(1e-4, 1e-3);
    built.place[at][axis] += length;
    const Record r = dice.chance(0.5) ? poses(dice, joints, 300) : motion(dice, joints, 3000);
    const Diagnosis d = judge(arm.model(resolution), log_of(dice, built, r, resolution, 1e-5));
    const std::string joint = "j" + std::to_string(at + 1);
    ASSERT_TRUE(tells(d, "geometry", joint)) << "seed " << seed << ": " << told(d);
    EXPECT_EQ(d.causes.size(), 1U) << "seed " << seed << ": " << told(d);
    EXPECT_TRUE(d.gain.held_out);
    EXPECT_GT(d.gain.ratio(), 1.2) << seed;
    if (d.causes[0].effect.joint != joint || !d.alternatives.empty()) continue;
    EXPECT_EQ(d.causes[0].effect.choices.at("axis"), std::string(1, "xyz"[axis])) << seed;
    ++intervals;
    inside += d.causes[0].parameters[0].lower <= length && length <= d.causes[0].parameters[0].upper;
  }
  EXPECT_GE(intervals, 12);
  EXPECT_GE(inside, intervals - 3);
}

TEST(DiagnoseTip, FindsNothingWrongWithACleanArm) {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Dice dice(1000 + seed);
    const std::size_t joints = 2 + dice.below(5);
    const Arm arm = random_arm(dice, joints);
    const std::vector<double> resolution(joints, std::pow(10, dice.between(-5, -3)));
    Record r = dice.chance(0.5) ? poses(dice, joints, 200) : motion(dice, joints, 1500);
    // A table does not tell the noise of its references.
    r.with_references = r.time.size() > 0 && dice.chance(0.4);
    const Diagnosis d =
        judge(arm.model(resolution), log_of(dice, arm, r, resolution, std::pow(10, dice.between(-6, -4))));
    if (d.verdict == Verdict::nothing_wrong) continue;
    ++alarms;
    std::printf("seed %d: %s\n", static_cast<int>(seed), told(d).c_str());
  }
  EXPECT_LE(alarms, 2);
}

TEST(DiagnoseTip, NamesWhatAnEncoderAddsByWhatItDoesToTheTip) {
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    Dice dice(2000 + seed);
    const std::size_t joints = 2 + dice.below(3);
    const Arm arm = random_arm(dice, joints);
    const double step = 2e-4;
    const std::vector<double> resolution(joints, step);
    Record r = motion(dice, joints, 4000);
    const std::size_t at = dice.below(joints);
    const auto j = static_cast<Eigen::Index>(at);
    const double size = dice.between(2, 8) * step;
    const char* effect = "";
    const Eigen::ArrayXd q = r.joints.row(j).transpose();
    Eigen::ArrayXd added(q.size());
    switch (seed % 4) {
      case 0:
        effect = "offset";
        added.setConstant(size);
        break;
      case 1:
        effect = "scale";
        added = size * q;
        break;
      case 2: {
        effect = "latency";  // a delay of half a sample and more, by the slope between neighbours
        const Eigen::Index last = q.size() - 1;
        added.setZero();
        added.tail(last) = -0.4 * (q.tail(last) - q.head(last));
        added[0] = added[1];
        break;
      }
      default: {
        effect = "backlash";  // the link lags behind a motor that does what q says
        double link = q[0];
        for (Eigen::Index k = 0; k < q.size(); ++k) {
          link = std::clamp(link, q[k] - size, q[k] + size);
          r.joints(j, k) = link;
          added[k] = q[k] - link;
        }
      }
    }
    r.additions.row(j) = added.matrix().transpose();
    const Diagnosis d = judge(arm.model(resolution), log_of(dice, arm, r, resolution, 1e-5));
    EXPECT_TRUE(tells(d, effect, "j" + std::to_string(at + 1)))
        << "seed " << seed << ", hidden " << effect << " at " << at + 1 << ": " << told(d);
  }
}

TEST(DiagnoseTip, SaysThatNoPoseTellsShiftsAlongParallelAxesApart) {
  Dice dice(5);
  const Arm arm{{{0, 0, 0.3}, {0.4, 0, 0}, {0.3, 0, 0.05}},
                {Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ()},
                {0.2, 0, 0}};
  Arm built = arm;
  built.place[1].z() += 5e-4;
  const std::vector<double> resolution(3, 1e-4);
  const Diagnosis d =
      judge(arm.model(resolution), log_of(dice, built, poses(dice, 3, 200), resolution, 1e-5));
  EXPECT_EQ(d.verdict, Verdict::ambiguous) << told(d);
  EXPECT_TRUE(tells(d, "geometry", "j2")) << told(d);
  ASSERT_FALSE(d.alternatives.empty());
  EXPECT_NE(d.alternatives[0].record.find("no pose"), std::string::npos) << d.alternatives[0].record;
}

TEST(DiagnoseTip, BlamesATrackerInAFrameOfItsOwnAndNotTheArm) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Dice dice(3000 + seed);
    const Arm arm = random_arm(dice, 6);
    const std::vector<double> resolution(6, 1e-5);
    const double size = seed % 2 == 1 ? 2e-3 : 1.5;  // [m] and rad
    const Eigen::Vector3d shift = size * dice.direction();
    const Eigen::Matrix3d turn = rotation(dice.direction(), size);
    const Log log = log_of(dice, arm, poses(dice, 6, 200), resolution, 2e-5,
                           [&](const Eigen::Vector3d& p) -> Eigen::Vector3d { return shift + turn * p; });
    const Diagnosis d = judge(arm.model(resolution), log);
    EXPECT_TRUE(d.causes.empty()) << "seed " << seed << ": " << told(d);
    ASSERT_FALSE(d.unexplained.empty()) << seed;
    EXPECT_EQ(d.unexplained[0].joint, "tip");
    EXPECT_NEAR(d.unexplained[0].amplitude, shift.norm(), 1e-4) << seed;
    EXPECT_FALSE(d.warnings.empty());
  }
}

TEST(DiagnoseTip, HalvesWhatALaserTrackerSeesOfAnUncalibratedArm) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Dice dice(4000 + seed);
    const Arm arm = random_arm(dice, 6);
    const std::vector<double> resolution(6, 1e-5);
    Arm built = arm;
    for (Eigen::Vector3d& place : built.place)
      place +=
          Eigen::Vector3d(dice.between(-0.3, 0.3), dice.between(-0.3, 0.3), dice.between(-0.3, 0.3)) * 1e-3;
    Record r = poses(dice, 6, 200);
    for (Eigen::Index j = 0; j < 6; ++j) r.additions.row(j).setConstant(dice.between(-4e-4, 4e-4));
    const Eigen::Vector3d shift = 1e-3 * dice.direction(), target = 2e-3 * dice.direction();
    built.tool += target;
    const Eigen::Matrix3d turn = rotation(dice.direction(), 1e-3);
    const Diagnosis d =
        judge(arm.model(resolution),
              log_of(dice, built, r, resolution, 2e-5,
                     [&](const Eigen::Vector3d& p) -> Eigen::Vector3d { return shift + turn * p; }));
    ASSERT_FALSE(d.causes.empty()) << seed;
    EXPECT_TRUE(d.causes[0].effect.type == "geometry" || d.causes[0].effect.type == "offset") << told(d);
    EXPECT_TRUE(d.verdict == Verdict::ambiguous || d.verdict == Verdict::partly_explained) << told(d);
    std::printf("seed %d: rms %.3g to %.3g mm (%.1f to %.1f times), %zu causes, %zu alternatives\n",
                static_cast<int>(seed), 1e3 * d.gain.rms_before, 1e3 * d.gain.rms_after, d.gain.lower,
                d.gain.upper, d.causes.size(), d.alternatives.size());
    EXPECT_GT(d.gain.lower, 2) << told(d);
    EXPECT_LT(d.gain.rms_after, 3e-5) << told(d);
  }
}

TEST(DiagnoseTip, SeesGeometryThatGoodSensorsOnAllJointsCannotExplain) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Dice dice(5000 + seed);
    const Arm arm = random_arm(dice, 4);
    const std::vector<double> resolution(4, 1e-4);
    Arm built = arm;
    built.place[2].x() += 3e-5;  // well below what the counts could show
    Record r = motion(dice, 4, 2000);
    r.with_references = true;
    r.additions.row(1).setConstant(4e-4);
    const Diagnosis d = judge(arm.model(resolution), log_of(dice, built, r, resolution, 1e-5));
    EXPECT_TRUE(tells(d, "offset", "j2")) << told(d);
    EXPECT_TRUE(tells(d, "geometry", "j3")) << told(d);
  }
}

TEST(DiagnoseTip, CannotJudgeWithoutTheTipOrReferences) {
  Dice dice(6);
  const Arm arm = random_arm(dice, 3);
  const std::vector<double> resolution(3, 1e-4);
  Log log = log_of(dice, arm, poses(dice, 3, 100), resolution, 1e-5);
  log.columns.resize(3);
  log.values.conservativeResize(Eigen::NoChange, 3);
  EXPECT_EQ(judge(arm.model(resolution), log).verdict, Verdict::cannot_judge);
}

}  // namespace
}  // namespace qerr
