#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "diagnose/inference/tip/tip_evidence.hpp"
#include "diagnose/inference/tip/tip_solution.hpp"
#include "simulate/sensing.hpp"
#include "support/posed_robot.hpp"

/// Parts of the inference at the tip by independent formulas: the least squares, the likelihood, and the
/// columns of every term by differences of the forward kinematics.
namespace qerr {
namespace {

using testing::Dice;
using testing::PosedRobot;

Eigen::MatrixXd uniform_matrix(Dice& dice, Eigen::Index rows, Eigen::Index columns) {
  Eigen::MatrixXd m(rows, columns);
  for (double& x : m.reshaped()) x = dice.between(-1, 1);
  return m;
}

/// A difference_at_tip of central differences; the terms are smooth.
template <class F>
Eigen::MatrixXd five_point_slope(const F& at, double h) {
  return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
}

TEST(NormalInverse, InvertsWhatHasFullRankInAnyUnits) {
  Dice dice(31);
  for (Eigen::Index n = 1; n <= 6; ++n) {
    const Eigen::MatrixXd x = uniform_matrix(dice, 20, n);
    Eigen::VectorXd units(n);
    for (double& u : units) u = std::pow(10, dice.between(-6, 6));
    const Eigen::MatrixXd normal = units.asDiagonal() * (x.transpose() * x) * units.asDiagonal();
    const NormalInverse got(normal);
    EXPECT_EQ(got.rank, n);
    const Eigen::MatrixXd left = units.asDiagonal() * got.inverse * units.asDiagonal() * (x.transpose() * x);
    EXPECT_LT((left - Eigen::MatrixXd::Identity(n, n)).norm(), 1e-9) << n;
  }
}

TEST(NormalInverse, OmitsDependentAndEmptyColumns) {
  Dice dice(32);
  for (Eigen::Index n = 3; n <= 7; ++n) {
    Eigen::MatrixXd x = uniform_matrix(dice, 20, n);
    x.col(1) = 0.3 * x.col(0);
    x.col(2).setZero();
    const NormalInverse got(x.transpose() * x);
    EXPECT_EQ(got.rank, n - 2);
    // The fitted values are those of any least squares; what is empty stays zero.
    const Eigen::VectorXd y = uniform_matrix(dice, 20, 1);
    const Eigen::VectorXd theta = got.inverse * (x.transpose() * y);
    EXPECT_LT((x.transpose() * (y - x * theta)).norm(), 1e-9) << n;
    EXPECT_EQ(theta[2], 0);
    EXPECT_LT((got.inverse - got.inverse.transpose()).norm(), 1e-9);
    EXPECT_EQ(NormalInverse(Eigen::MatrixXd::Zero(n, n)).rank, 0);
  }
  EXPECT_EQ(NormalInverse(Eigen::MatrixXd(0, 0)).rank, 0);
}

double log_normal_density(double x, double variance) {
  return -0.5 * (std::log(2 * std::numbers::pi * variance) + x * x / variance);
}

double log_likelihood_of_entries(const Eigen::VectorXd& residual, const Eigen::VectorXd& known,
                                 double sigma) {
  double sum = 0;
  for (Eigen::Index i = 0; i < residual.size(); ++i)
    sum += log_normal_density(residual[i], known[i] + sigma * sigma);
  return sum;
}

TEST(TipSolution, MaximizesTheLikelihoodOverCoefficientsAndSigma) {
  Dice dice(33);
  for (int i = 0; i < 60; ++i) {
    const Eigen::Index rows = 40 + 10 * static_cast<Eigen::Index>(dice.below(10));
    const auto columns = static_cast<Eigen::Index>(dice.below(5));
    const Eigen::MatrixXd x = uniform_matrix(dice, rows, columns);
    const Eigen::VectorXd truth = uniform_matrix(dice, columns, 1);
    const double sigma = std::pow(10, dice.between(-4, 0)), least = 1e-6;
    Eigen::VectorXd known(rows), y = x * truth;
    for (Eigen::Index k = 0; k < rows; ++k) {
      known[k] = std::pow(dice.between(0, 2) * (i % 3) * sigma, 2);
      y[k] += std::sqrt(known[k] + sigma * sigma) * testing::gaussian(dice);
    }
    const TipSolution s = solve(x, y, known, least);
    EXPECT_NEAR(s.log_likelihood, log_likelihood_of_entries(s.residual, known, s.sigma),
                1e-9 * std::abs(s.log_likelihood));
    EXPECT_LT((s.residual - (y - x * s.theta)).norm(), 1e-12 * (1 + y.norm()));
    EXPECT_EQ(s.rank, columns);
    EXPECT_GE(s.sigma, least);
    for (const double by : {0.99, 1.01})
      EXPECT_LE(log_likelihood_of_entries(s.residual, known, std::max(least, by * s.sigma)),
                s.log_likelihood + 1e-2);
    // The last coefficients belong to a sigma that differed by less than 1 %.
    const Eigen::VectorXd variance = s.weight.cwiseInverse();
    for (Eigen::Index k = 0; k < rows; ++k)
      EXPECT_NEAR(variance[k], known[k] + s.sigma * s.sigma, 0.021 * s.sigma * s.sigma);
    if (columns == 0) continue;
    const Eigen::MatrixXd weighted = s.weight.asDiagonal() * x;
    EXPECT_LT((weighted.transpose() * s.residual).norm(), 1e-9 * (weighted.transpose() * y).norm());
    EXPECT_LT(
        (s.covariance * (x.transpose() * weighted) - Eigen::MatrixXd::Identity(columns, columns)).norm(),
        1e-9);
    // Five standard errors, of which chance exceeds none in some hundred coefficients.
    for (Eigen::Index c = 0; c < columns; ++c)
      EXPECT_LT(std::abs(s.theta[c] - truth[c]), 5 * std::sqrt(s.covariance(c, c)));
  }
}

TEST(TipSolution, HasTheLeastSigmaWhereTheKnownVarianceExplainsAll) {
  const Eigen::VectorXd y = Eigen::VectorXd::LinSpaced(50, -1e-3, 1e-3),
                        known = Eigen::VectorXd::Constant(50, 1.0);
  const TipSolution s = solve(Eigen::MatrixXd(50, 0), y, known, 1e-5);
  EXPECT_GE(s.sigma, 1e-5);
  EXPECT_LT(s.sigma, 1.1e-5);
  EXPECT_EQ(s.theta.size(), 0);
  EXPECT_EQ(s.residual, y);
  EXPECT_EQ(s.rank, 0);
}

TEST(TipPose, IsThatOfTheForwardKinematicsAndHasItsDerivatives) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Dice dice(4000 + seed);
    PosedRobot r(dice, 2 + seed % 5, 4, seed);
    for (double& x : r.estimate.additions.reshaped()) x = dice.between(-1e-2, 1e-2);
    for (Eigen::Index k = 0; k < 4; ++k) {
      const TipPose p = r.estimate.pose(r.evidence, k);
      EXPECT_LT((p.tip - r.tip(r.estimate, k)).norm(), 1e-12);
      const Eigen::VectorXd q = r.evidence.joints.col(k) - r.evidence.to_joints * r.estimate.additions.col(k);
      const Eigen::Matrix3d axes = (r.estimate.base * forward_kinematics(r.estimate.chain, q)).linear();
      EXPECT_LT((p.tool - axes).norm(), 1e-12);
      for (Eigen::Index i = 0; i < q.size(); ++i) {
        const auto by_joint = [&](double h) -> Eigen::MatrixXd {
          const Eigen::VectorXd moved = q + h * Eigen::VectorXd::Unit(q.size(), i);
          return r.estimate.base * (forward_kinematics(r.estimate.chain, moved) * r.estimate.tool);
        };
        EXPECT_LT((p.joints.col(i) - five_point_slope(by_joint, 1e-3)).norm(), 1e-9);
        const auto by_encoder = [&](double h) -> Eigen::MatrixXd {
          TipEstimate moved = r.estimate;
          moved.additions(i, k) -= h;
          return r.tip(moved, k);
        };
        EXPECT_LT((p.encoders.col(i) - five_point_slope(by_encoder, 1e-3)).norm(), 1e-9);
      }
    }
  }
}

/// estimate - true where a robot is as built with a small change, from the forward kinematics of both.
Eigen::MatrixXd difference_at_tip(const PosedRobot& r, const TipTerm& t, Eigen::Index coefficient,
                                  Eigen::Index row, double h) {
  TipEstimate built = r.estimate;
  const Eigen::VectorXd c = h * Eigen::VectorXd::Unit(t.size(), coefficient);
  const auto place = static_cast<Eigen::Index>(t.where);
  switch (t.kind) {
    case TipTerm::Kind::geometry: {
      Effect effect = t.term.effect;
      t.term.fill(effect, c);
      built.chain = as_built(r.estimate.chain, {effect});
      break;
    }
    case TipTerm::Kind::frame_tilt:
    case TipTerm::Kind::axis_tilt:
      tilt(built.chain.joints[t.where], t.kind, t.directions * c);
      break;
    case TipTerm::Kind::base: {
      Eigen::Isometry3d shift = Eigen::Isometry3d::Identity();
      shift.translate(c.head<3>());
      if (c.tail<3>().norm() > 0)
        shift.rotate(Eigen::AngleAxisd(c.tail<3>().norm(), c.tail<3>().normalized()));
      built.base = shift * built.base;
      break;
    }
    case TipTerm::Kind::tool:
      built.tool += c;
      break;
    case TipTerm::Kind::late:
      break;  // of records in time, which these are not
    case TipTerm::Kind::tracker:
    case TipTerm::Kind::target: {  // what is tracked is displaced from the model's tip
      Eigen::Vector3d moved = Eigen::Vector3d::Zero();
      for (Eigen::Index i = 0; i < t.term.size(); ++i)
        moved += t.term.columns(row, i) * t.directions * c.segment(i * 3, 3);
      const Eigen::Matrix3d axes = r.estimate.pose(r.evidence, row).tool;
      return t.kind == TipTerm::Kind::target ? Eigen::Vector3d(-axes * moved) : Eigen::Vector3d(-moved);
    }
    case TipTerm::Kind::growth: {  // the link before the joint, or the one that carries the tip, is longer
      const bool last = t.where == built.chain.joints.size();
      Eigen::Isometry3d& link = last ? built.chain.tip_offset : built.chain.joints[t.where].origin;
      for (Eigen::Index i = 0; i < t.term.size(); ++i)
        link.translation() += t.term.columns(row, i) * t.directions * c.segment(i, 1);
      break;
    }
    case TipTerm::Kind::encoder:  // the joint is where the reading less its error says
      built.additions(place, row) += (t.term.columns.row(row).matrix() * c).value();
  }
  return r.tip(r.estimate, row) - r.tip(built, row);
}

TEST(TipTerm, HasTheDerivativesOfTheForwardKinematicsAsColumns) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Dice dice(4100 + seed);
    const PosedRobot r(dice, 2 + seed % 5, 3, seed);
    std::vector<TipTerm> terms = tilt_terms(r.model.chain);
    for (TipTerm& t : tip_terms(r.evidence, r.estimate)) terms.push_back(std::move(t));
    terms.push_back({TipTerm::Kind::base, {}, 0});
    terms.push_back({TipTerm::Kind::tool, {}, 0});
    for (const TipTerm::Kind kind : {TipTerm::Kind::tracker, TipTerm::Kind::target}) {
      TipTerm t{kind, {}, 0};
      t.term.columns = Eigen::ArrayXXd::Random(r.evidence.rows(), 2);
      t.directions.setIdentity(3, 3);
      terms.push_back(std::move(t));
    }
    for (std::size_t j = 0; j <= r.model.chain.joints.size(); ++j) {
      TipTerm t{TipTerm::Kind::growth, {}, j};
      t.term.columns = Eigen::ArrayXXd::Random(r.evidence.rows(), 2);
      t.directions = Eigen::Vector3d::Random().normalized();
      terms.push_back(std::move(t));
    }
    for (const TipTerm& t : terms)
      for (Eigen::Index k = 0; k < r.evidence.rows(); ++k) {
        const TipPose pose = r.estimate.pose(r.evidence, k);
        const Eigen::Matrix3Xd columns = t.at(pose, r.evidence, r.estimate, k);
        ASSERT_EQ(columns.cols(), t.size());
        for (Eigen::Index i = 0; i < t.size(); ++i) {
          const auto at = [&](double h) { return difference_at_tip(r, t, i, k, h); };
          const Eigen::Vector3d expected = five_point_slope(at, 1e-3);
          EXPECT_LT((columns.col(i) - expected).norm(), 1e-8 * (1 + expected.norm()))
              << t.term.effect.type << ' ' << t.term.unnamed << " kind " << static_cast<int>(t.kind) << " at "
              << t.where << ", coefficient " << i << ", seed " << seed;
        }
      }
  }
}

TEST(TipTerm, TiltsEveryAxisAboutTwoDirectionsAcrossIt) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Dice dice(4200 + seed);
    const Chain chain = make_chain(random_robot(dice, {2 + seed % 5}), "", "");
    std::vector<std::size_t> frames, axes;
    for (const TipTerm& t : tilt_terms(chain)) {
      (t.kind == TipTerm::Kind::frame_tilt ? frames : axes).push_back(t.where);
      const ChainJoint& joint = chain.joints[t.where];
      ASSERT_EQ(t.directions.cols(), 2);
      EXPECT_LT((t.directions.transpose() * t.directions - Eigen::Matrix2d::Identity()).norm(), 1e-12);
      const Eigen::Vector3d axis = joint.origin.linear() * joint.axis;
      EXPECT_LT((t.directions.transpose() * axis).norm(), 1e-12);
      EXPECT_EQ(t.slides, joint.prismatic);
      EXPECT_FALSE(t.term.named());
      EXPECT_EQ(t.term.effect.joint, chain.independent[joint.coordinate].name);
      EXPECT_NE(t.term.next.find(t.kind == TipTerm::Kind::frame_tilt ? "<origin>" : "<axis>"),
                std::string::npos);
      Effect filled = t.term.effect;
      t.term.fill(filled, Eigen::Vector2d(3e-3, 4e-3));
      EXPECT_NEAR(filled.number("amplitude"), 5e-3, 1e-15);
    }
    std::vector<std::size_t> all, turning;
    for (std::size_t j = 0; j < chain.joints.size(); ++j) {
      all.push_back(j);
      if (j > 0 && !chain.joints[j].prismatic) turning.push_back(j);
    }
    EXPECT_EQ(axes, all);
    EXPECT_EQ(frames, turning);
  }
}

}  // namespace
}  // namespace qerr
