#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "diagnose/inference/tip/tip_select.hpp"
#include "diagnose/inference/tip/tip_weight.hpp"
#include "simulate/sensing.hpp"
#include "support/measured_tip.hpp"
#include "support/posed_robot.hpp"

/// Every figure of models of a tracked tip: what the evidence is, what a candidate is worth, what is chosen.
namespace qerr {
namespace {

using testing::Dice;
using testing::expect_candidates;
using testing::expect_evidence;
using testing::expect_model;
using testing::expect_selection;
using testing::figures_of_tips;
using testing::PosedRobot;
using testing::RecordFigures;

/// Robots of all kinds in random poses: displaced joints, turned axes, offsets, noise.
TEST(TipModelFigures, OfModelsOfPosedRobotsAreAsMeasured) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Dice dice(6000 + seed);
    PosedRobot r(dice, 2 + seed % 3, 40, seed);
    const bool framed = seed % 3 == 0;
    TipEstimate built = r.estimate;
    if (!framed) built.base = Eigen::Isometry3d::Identity(), built.tool.setZero();
    if (seed % 4 != 0)
      for (ChainJoint& joint : built.chain.joints) joint.origin.translation() += 1e-3 * dice.direction();
    for (std::size_t j = 0; j < built.chain.joints.size(); ++j)
      tilt(built.chain.joints[j], TipTerm::Kind::axis_tilt,
           built.chain.joints[j].parent_axes * (2e-3 * dice.direction()));
    for (Eigen::Index i = 0; i < built.additions.rows(); ++i)
      built.additions.row(i).setConstant(dice.between(-2e-3, 2e-3));
    for (Eigen::Index k = 0; k < r.evidence.rows(); ++k) {
      const Eigen::Vector3d tip = r.tip(built, k);
      for (std::size_t i = 0; i < r.evidence.axes.size(); ++i)
        r.evidence.tip(static_cast<Eigen::Index>(i), k) =
            tip[r.evidence.axes[i]] + 1e-4 * testing::gaussian(dice);
    }
    if (seed % 2 == 0) r.evidence.encoders[0].encoder.zero_known = false;
    r.evidence.noise = seed % 5 == 0 ? 1e-4 : 0;
    r.evidence.log_resolution = seed % 5 == 1 ? 2e-4 : 0;
    const RecordFigures figure(figures_of_tips(), "posed " + std::to_string(seed));
    for (const UnknownFrames frames :
         {UnknownFrames{}, UnknownFrames{.target = true}, UnknownFrames{true, true}}) {
      if (frames.base != framed) continue;  // far from the data a fit is chaotic
      const std::string start = "frames " + std::to_string(frames.base ? 2 : frames.target) + ' ';
      TipModel m(r.model, r.evidence, frames, 9);
      expect_model(figure, start, m);
      if (!frames.target || frames.base) expect_candidates(figure, start, m);
      // Two tilts, an offset and a length, then one less, and one in the place of another.
      std::vector<TipTerm> all = tip_candidates(m);
      const std::size_t from = dice.below(3);
      for (std::size_t i = from; i < all.size(); i += 3)
        if (m.terms().size() < 4) m.add(all[i], Eigen::VectorXd::Zero(all[i].size()));
      m.fit();
      expect_model(figure, start + "more ", m);
      m.remove(1);
      m.exchange(0, all[from + 1], Eigen::VectorXd::Constant(all[from + 1].size(), 1e-4));
      m.fit();
      expect_model(figure, start + "other ", m);
    }
  }
}

struct TipRecord {
  OperationalModel model;
  Log log;
};

/// An arm that moves, with errors of its links and of its encoders, and a log with efforts.
TipRecord moved_arm(std::uint64_t seed) {
  Dice dice(6100 + seed);
  const std::size_t joints = seed % 8 == 3 || seed % 8 == 4 ? 3 : 2;
  const testing::Arm arm = testing::random_arm(dice, joints);
  testing::Arm built = arm;
  testing::Record r = testing::motion(dice, joints, 480 + 10 * static_cast<Eigen::Index>(seed));
  if (seed % 4 == 1) r.joints.leftCols(120).colwise() = r.joints.col(120).eval();  // it rests at first
  const double step = 3e-4;
  switch (seed % 8) {
    case 0:
      built.place[1].y() += 6e-4;
      break;
    case 1:
      for (Eigen::Index k = 0; k < r.joints.cols(); ++k)
        r.additions(1, k) = 5 * step * std::sin(9.4 * r.joints(1, k) + 0.4);
      break;
    case 2:
      r.additions.row(0).tail(220).setConstant(-5 * step);
      break;
    case 3: {
      double link = r.joints(0, 0);
      for (Eigen::Index k = 0; k < r.joints.cols(); ++k) {
        const double motor = r.joints(0, k);
        link = std::clamp(link, motor - 4 * step, motor + 4 * step);
        r.joints(0, k) = link;
        r.additions(0, k) = motor - link;
      }
      break;
    }
    case 4:
      built.axis[1] = testing::rotation(Eigen::Vector3d::UnitX(), 4e-3) * built.axis[1];
      r.additions.row(0).array() += 3 * step;
      break;
    case 5:
      built.tool += Eigen::Vector3d(1e-3, -5e-4, 0);
      break;
    case 6:
      r.with_references = true;
      built.place[1].z() -= 5e-4;
      break;
    default:
      built.place[1].y() += 7e-4;
      r.additions.row(0).array() -= 4 * step;
      r.additions.row(1) += 6 * step * r.joints.row(1);
  }
  const std::vector<double> resolution(joints, step);
  TipRecord made{arm.model(resolution), testing::log_of(dice, built, r, resolution, 2e-5)};
  if (seed % 3 == 1) {
    const Eigen::Index columns = made.log.values.cols();
    made.log.values.conservativeResize(Eigen::NoChange, columns + 2);
    for (Eigen::Index k = 0; k < r.joints.cols(); ++k) {
      made.log.values(k, columns) = std::cos(r.joints(0, k));
      made.log.values(k, columns + 1) = 20 + 0.004 * static_cast<double>(k);
    }
    made.log.columns.push_back(testing::column(LogSignal::effort, 0, 6));
    made.log.columns.push_back(testing::column(LogSignal::temperature, 0, 6));
  }
  if (seed % 5 == 2) made.model.transmission.encoders[1].zero_known = false;
  return made;
}

TEST(TipModelFigures, OfSelectionsFromMotionsAreAsMeasured) {
  for (std::uint64_t seed = 1; seed <= 9; ++seed) {
    const TipRecord r = moved_arm(seed);
    const std::vector<Effect> present =
        seed % 6 == 5 ? std::vector<Effect>{{"offset", "j1", {{"offset", 2e-4}}, {}}} : std::vector<Effect>{};
    const auto e = tip_evidence(r.model, present, r.log, 1);
    ASSERT_TRUE(e);
    const RecordFigures figure(figures_of_tips(), "moved " + std::to_string(seed));
    expect_evidence(figure, *e);
    const TipModel m(r.model, *e, {}, 3);
    if (seed % 2 == 0) expect_candidates(figure, "", m);
    expect_selection(figure, select_tip(r.model, *e, 5));
  }
}

/// The search for alternatives mends a model with a wrong term.
TEST(TipModelFigures, OfExchangesOfWrongTermsAreAsMeasured) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Dice dice(6200 + seed);
    const std::size_t joints = 3 + seed % 2;
    const testing::Arm arm = testing::random_arm(dice, joints);
    testing::Arm built = arm;
    built.place[1].x() += 7e-4;
    built.place[2].z() -= seed % 2 == 0 ? 6e-4 : 0;
    testing::Record record = testing::poses(dice, joints, 60);
    record.joints *= seed % 3 == 0 ? 0.1 : 0.6;
    record.additions.row(0).setConstant(1e-3);
    const std::vector<double> resolution(joints, 1e-4);
    const OperationalModel model = arm.model(resolution);
    const Log log = testing::log_of(dice, built, record, resolution, 2e-5);
    const auto e = tip_evidence(model, {}, log, 1);
    ASSERT_TRUE(e);
    TipModel wrong(model, *e, UnknownFrames{.target = seed % 4 == 3}, 4);
    std::vector<TipTerm> all = tip_terms(*e, wrong.estimate());
    for (std::size_t i = seed % 3; i < all.size() && wrong.terms().size() < 3; i += 4)
      if (!wrong.beyond(wrong.columns(all[i])).isZero(0)) {
        wrong.add(all[i], Eigen::VectorXd::Zero(1));
        wrong.fit();
      }
    const RecordFigures figure(figures_of_tips(), "exchanged " + std::to_string(seed));
    expect_model(figure, "wrong ", wrong);
    TipSelection s{std::move(wrong), {}, {}};
    find_tip_alternatives(model, s);
    expect_selection(figure, s);
  }
}

/// Of long records every n-th group of rows is used.
TEST(TipModelFigures, OfEvidenceOfLongRecordsAreAsMeasured) {
  for (const Eigen::Index rows : {4000, 4001, 9000})
    for (const bool moves : {false, true}) {
      Dice dice(6300);
      const testing::Arm arm = testing::random_arm(dice, 2);
      const testing::Record record = moves ? testing::motion(dice, 2, rows) : testing::poses(dice, 2, rows);
      const std::vector<double> resolution(2, 1e-4);
      const OperationalModel model = arm.model(resolution);
      const auto e = tip_evidence(model, {}, testing::log_of(dice, arm, record, resolution, 2e-5), 1);
      ASSERT_TRUE(e);
      const RecordFigures figure(figures_of_tips(),
                                 "long " + std::to_string(rows) + (moves ? " moved" : " posed"));
      expect_evidence(figure, *e);
    }
}

/// Together with an unknown target, which may lie elsewhere along the axis of the last joint, two directions
/// of its origin determine the third one.
TEST(TipAlternatives, OfOneDirectionAreTheOthersWhereTheTargetIsUnknown) {
  Dice dice(6400);
  testing::Arm arm = testing::random_arm(dice, 2);
  arm.axis[1] = Eigen::Vector3d(0.5, 0.7, 0.6).normalized();
  testing::Arm built = arm;
  built.place[1] += Eigen::Vector3d(9e-4, 7e-4, 0);
  const std::vector<double> resolution(2, 1e-4);
  const OperationalModel model = arm.model(resolution);
  const auto e = tip_evidence(
      model, {}, testing::log_of(dice, built, testing::poses(dice, 2, 100), resolution, 2e-5), 1);
  ASSERT_TRUE(e);
  TipModel m(model, *e, {.target = true}, 4);
  for (const TipTerm& t : tip_terms(*e, m.estimate()))
    if (t.kind == TipTerm::Kind::geometry && t.where == 1 && t.term.effect.choices.at("axis") != "z")
      m.add(t, Eigen::VectorXd::Zero(1));
  m.fit();
  TipSelection s{std::move(m), {}, {}};
  find_tip_alternatives(model, s);
  EXPECT_EQ(s.model.terms().size(), 2U);
  for (std::size_t term = 0; term < 2; ++term)
    EXPECT_TRUE(std::any_of(s.alternatives.begin(), s.alternatives.end(), [&](const TipAlternative& a) {
      return a.term == term && a.everywhere && a.other.kind == TipTerm::Kind::geometry &&
             a.other.where == 1 && std::abs(a.loss) < 1e-3;
    })) << term;
}

/// What a candidate gains is what its columns gain beyond those of the model, also of those that it nearly
/// has.
TEST(TipModel, GainOfColumnsIsThatOfWhatTheModelLeavesOfThem) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Dice dice(6500 + seed);
    const testing::Arm arm = testing::random_arm(dice, 3);
    testing::Arm built = arm;
    built.place[1].x() += 7e-4;
    const std::vector<double> resolution(3, 1e-4);
    const OperationalModel model = arm.model(resolution);
    const testing::Record record =
        seed % 2 == 0 ? testing::motion(dice, 3, 300) : testing::poses(dice, 3, 60);
    const auto e = tip_evidence(model, {}, testing::log_of(dice, built, record, resolution, 2e-5), 1);
    ASSERT_TRUE(e);
    TipModel m(model, *e, {.base = seed % 3 == 0}, 4);
    const std::vector<TipTerm> all = tip_terms(*e, m.estimate());
    m.add(all[seed], Eigen::VectorXd::Zero(all[seed].size()));
    m.fit();
    for (const TipTerm& t : all) {
      const Eigen::MatrixXd columns = m.columns(t);
      const double gain = gain_of(m.solution(), m.beyond(columns));
      EXPECT_NEAR(m.gain(columns), gain, 1e-6 * (1 + gain)) << seed << ' ' << t.term.effect.type;
    }
  }
}

}  // namespace
}  // namespace qerr
