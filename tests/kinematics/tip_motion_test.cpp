#include <gtest/gtest.h>

#include "qerr/kinematics/chain.hpp"
#include "simulate/along_motion.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::Dice;

struct State {
  Eigen::VectorXd q, velocity, acceleration;

  State after(double time) const {
    return {q + time * velocity + 0.5 * time * time * acceleration, velocity + time * acceleration,
            acceleration};
  }
};

State random_state(Dice& dice, const Chain& chain) {
  const auto n = static_cast<Eigen::Index>(chain.independent.size());
  return {dice.vector(n, -2, 2), dice.vector(n, -3, 3), dice.vector(n, -9, 9)};
}

TEST(TipMotion, VelocityIsTheJacobianTimesThatOfTheJoints) {
  Dice dice(5);
  for (int i = 0; i < 100; ++i) {
    const Chain chain = make_chain(testing::random_robot(dice, {1 + dice.below(8)}), "", "");
    const State s = random_state(dice, chain);
    const TipMotion tip = tip_motion(chain, s.q, s.velocity, s.acceleration);
    const Eigen::Vector3d expected = (jacobian(chain, s.q) * s.velocity).head<3>();
    EXPECT_LT((tip.velocity - expected).norm(), 1e-13 * (1 + expected.norm()));
    EXPECT_LT((tip.pose.matrix() - forward_kinematics(chain, s.q).matrix()).norm(), 1e-13);
  }
}

TEST(TipMotion, AccelerationIsTheDerivativeOfTheVelocity) {
  Dice dice(6);
  constexpr double step = 1e-5;  // the difference is in error by about its square and 1e-16/step
  for (int i = 0; i < 100; ++i) {
    const Chain chain = make_chain(testing::random_robot(dice, {1 + dice.below(8)}), "", "");
    const State s = random_state(dice, chain);
    const auto velocity_after = [&](double time) {
      const State later = s.after(time);
      return tip_motion(chain, later.q, later.velocity, later.acceleration).velocity;
    };
    const Eigen::Vector3d difference = (velocity_after(step) - velocity_after(-step)) / (2 * step);
    const Eigen::Vector3d found = tip_motion(chain, s.q, s.velocity, s.acceleration).acceleration;
    EXPECT_LT((found - difference).norm(), 1e-5 * (1 + found.norm()));
  }
}

}  // namespace
}  // namespace qerr
