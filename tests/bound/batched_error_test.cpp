#include "bound/batched_error.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "lanes/batch.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/filter/family.hpp"
#include "support/random_model.hpp"

namespace qerr {
namespace {

using testing::all_coordinates;
using testing::Dice;
using testing::random_model;

/// sqrt(sum_i (J C Delta)_ji^2 noise_i^2), plus the contributions of the sources, scaled by their ratios.
double sigma_in_motion(const OperationalError& e, Eigen::Index row, const Eigen::VectorXd& noise,
                       const Eigen::VectorXd& ratios) {
  const double added = ratios.size() > 0 ? e.added_sigma.row(row).cwiseProduct(ratios.transpose()).norm() : 0;
  return std::hypot(e.weighted.row(row).cwiseProduct(noise.transpose()).norm(), added);
}

struct Case {
  OperationalModel model;
  ErrorFigures asked;
  AlignedNumbers q;
};

Case random_case(Dice& dice, double square) {
  const std::size_t filters = dice.below(3);
  Case c{random_model(dice, filters, square), {}, {}};
  for (std::size_t f = 0; f < filters; ++f) {
    c.asked.filters.push_back(norms(difference_filter(1000, 1 + static_cast<int>(f))));
    c.asked.noise_in_motion.push_back(
        dice.chance(0.5)
            ? dice.vector(static_cast<Eigen::Index>(c.model.transmission.encoders.size()), 0, 500)
            : Eigen::VectorXd());
  }
  c.q = AlignedNumbers(c.model.chain.independent.size() * batch_size);
  for (std::size_t i = 0; i < c.q.size(); ++i) c.q[i] = dice.between(-3.2, 3.2);
  return c;
}

Eigen::VectorXd configuration(const Case& c, std::size_t i) {
  Eigen::VectorXd q(static_cast<Eigen::Index>(c.model.chain.independent.size()));
  for (Eigen::Index j = 0; j < q.size(); ++j) q[j] = c.q[static_cast<std::size_t>(j) * batch_size + i];
  return q;
}

bool near(double a, double b, double scale) { return std::abs(a - b) <= 1e-12 * scale + 1e-300; }

/// Every figure of every configuration against the scalar functions, on one instruction set.
void check(const Case& c, InstructionSet set) {
  BatchedError batched(c.model, c.asked, set);
  const FigureLayout& at = batched.figures();
  AlignedNumbers figures(at.count * batch_size);
  batched(c.q.data(), figures.data());
  const std::size_t m = c.model.coordinates.size();
  OperationalModel pose =
      c.model;  // a coordinate that no joint moves is only a rounding error of the others' size
  pose.coordinates.assign(all_coordinates, all_coordinates + 6);
  for (std::size_t i = 0; i < batch_size; ++i) {
    const OperationalError e = operational_error(c.model, configuration(c, i));
    const double size = operational_error(pose, configuration(c, i)).worst_case.maxCoeff();
    if (e.cosine_of_pitch < 1e-3) continue;  // every bound grows without limit
    const auto figure = [&](std::size_t f) { return figures[f * batch_size + i]; };
    for (std::size_t r = 0; r < m; ++r) {
      const auto row = static_cast<Eigen::Index>(r);
      // Roll and yaw are scaled by 1/cos(pitch), and so are their rounding errors.
      const double scale = std::max(size, e.worst_case.maxCoeff()) / (e.cosine_of_pitch * e.cosine_of_pitch);
      RC_ASSERT(near(figure(at.worst_case + r), e.worst_case[row], scale));
      RC_ASSERT(near(figure(at.sigma + r), e.sigma[row], scale));
      RC_ASSERT(figure(at.rigorous + r) == e.rigorous[row] ||
                near(figure(at.rigorous + r), e.rigorous[row], scale));
      for (std::size_t f = 0; f < c.asked.filters.size(); ++f) {
        const Norms& norms = c.asked.filters[f];
        const Eigen::VectorXd ratios = sigma_ratios(c.model.sources, f, norms.h2);
        const Bounds b = derivative_error(e, row, norms, ratios);
        const double worst = batched.own_worst_case() ? figure(at.filtered_worst + f * m + r)
                                                      : norms.l1.upper * figure(at.worst_case + r);
        const double sigma =
            batched.own_sigma() ? figure(at.filtered_sigma + f * m + r) : norms.h2 * figure(at.sigma + r);
        const double behind = scale * std::max(1.0, norms.l1.upper);
        RC_ASSERT(near(worst, b.worst_case, behind));
        RC_ASSERT(near(sigma, b.sigma, behind));
        const Eigen::VectorXd& noise = c.asked.noise_in_motion[f];
        if (noise.size() > 0)
          RC_ASSERT(
              near(figure(at.in_motion + f * m + r), sigma_in_motion(e, row, noise, ratios), 1e3 * behind));
      }
    }
  }
}

RC_GTEST_PROP(BatchedError, EqualsTheScalarOneForRandomModels, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  const Case c = random_case(dice, *rc::gen::element(0.0, 0.8, 1.0));
  for (const InstructionSet set : available_instruction_sets()) check(c, set);
}

// Sums over a batch: covariance, each encoder's share of the variance and of the worst case, its largest
// lever arm.
RC_GTEST_PROP(BatchedError, SumsAreThoseOfTheScalarErrors, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  Case c = random_case(dice, 0);
  c.model.sources.clear();
  std::erase_if(c.model.coordinates, [](Coordinate k) { return is_euler_angle(k); });
  if (c.model.coordinates.empty()) c.model.coordinates = {Coordinate::y};
  const auto m = static_cast<Eigen::Index>(c.model.coordinates.size());
  const auto n = static_cast<Eigen::Index>(c.model.transmission.encoders.size());
  Eigen::MatrixXd covariance_sum = Eigen::MatrixXd::Zero(m, m), share = Eigen::MatrixXd::Zero(m, n),
                  worst = share;
  Eigen::VectorXd arms = Eigen::VectorXd::Zero(n);
  for (std::size_t i = 0; i < batch_size; ++i) {
    const OperationalError e = operational_error(c.model, configuration(c, i));
    covariance_sum += covariance(e);
    for (Eigen::Index r = 0; r < m; ++r) {
      if (e.sigma[r] <= 1e-13 * e.sigma.maxCoeff()) continue;
      share.row(r) += e.weighted.row(r).cwiseAbs2() / e.weighted.row(r).squaredNorm();
      worst.row(r) += e.weighted.row(r).cwiseAbs() / e.weighted.row(r).cwiseAbs().sum();
      if (!is_position(c.model.coordinates[static_cast<std::size_t>(r)])) continue;
      arms = arms.cwiseMax(
          e.weighted.row(r).transpose().cwiseAbs().cwiseQuotient(resolutions(c.model.transmission)));
    }
  }
  for (const InstructionSet set : available_instruction_sets()) {
    BatchedError batched(c.model, c.asked, set);
    AlignedNumbers figures(batched.figures().count * batch_size);
    batched(c.q.data(), figures.data());
    const std::vector<double> sums = batched.take_sums();
    const SumLayout& at = batched.sums();
    const auto sum = [&](std::size_t i) { return sums[i]; };
    for (Eigen::Index r = 0, entry = 0; r < m; ++r)
      for (Eigen::Index k = 0; k <= r; ++k)
        RC_ASSERT(near(sum(at.covariance + static_cast<std::size_t>(entry++)), covariance_sum(r, k),
                       covariance_sum.diagonal().maxCoeff()));
    for (Eigen::Index r = 0; r < m; ++r)
      for (Eigen::Index k = 0; k < n; ++k) {
        const auto i = static_cast<std::size_t>(r * n + k);
        RC_ASSERT(std::abs(sum(at.share + i) - share(r, k)) < 1e-9);
        RC_ASSERT(std::abs(sum(at.worst_share + i) - worst(r, k)) < 1e-9);
      }
    for (Eigen::Index k = 0; k < n; ++k)
      RC_ASSERT(std::abs(sum(at.arms + static_cast<std::size_t>(k)) - arms[k]) <
                1e-12 * (1 + arms.maxCoeff()));
    for (const double again : batched.take_sums()) RC_ASSERT(again == 0);
  }
}

TEST(BatchedError, EulerAnglesHaveNoBoundAtTheGimbalLock) {
  RobotModel robot{"two", "two.urdf", {"base", "a", "tip"}, {}, {}};
  for (const char* child : {"a", "tip"})
    robot.joints.push_back({std::string("to_") + child,
                            JointType::revolute,
                            *child == 'a' ? "base" : "a",
                            child,
                            Eigen::Isometry3d::Identity(),
                            *child == 'a' ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY(),
                            {},
                            {},
                            {}});
  OperationalModel m{
      make_chain(robot, "", ""), {}, {Coordinate::x, Coordinate::roll, Coordinate::pitch, Coordinate::yaw}};
  m.transmission = {{{1e-3}, {1e-3}}, Eigen::Matrix2d::Identity()};
  AlignedNumbers q(2 * batch_size);
  for (std::size_t i = 0; i < batch_size; ++i) q[batch_size + i] = i % 2 ? std::numbers::pi / 2 : 0.3;
  for (const InstructionSet set : available_instruction_sets()) {
    BatchedError batched(m, {}, set);
    AlignedNumbers figures(batched.figures().count * batch_size);
    batched(q.data(), figures.data());
    for (std::size_t i = 0; i < batch_size; ++i)
      for (const std::size_t f : {batched.figures().worst_case, batched.figures().sigma}) {
        EXPECT_EQ(std::isinf(figures[(f + 1) * batch_size + i]), i % 2 == 1);
        const double pitch = figures[(f + 2) * batch_size + i];
        if (i % 2 == 1) {
          EXPECT_TRUE(std::isinf(pitch));
        } else {
          EXPECT_NEAR(pitch, f == 0 ? 0.5e-3 : 1e-3 / std::sqrt(12.0), 1e-15)
              << "the second joint turns by the pitch itself";
        }
        EXPECT_EQ(std::isinf(figures[(f + 3) * batch_size + i]), i % 2 == 1);
      }
    EXPECT_NEAR(1 - batched.take_sums()[batched.sums().pitch], 0, 1e-15);
  }
}

}  // namespace
}  // namespace qerr
