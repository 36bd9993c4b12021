#include <gtest/gtest.h>

#include <cmath>

#include "bound/batched_error.hpp"
#include "bound/signal_errors.hpp"
#include "qerr/filter/family.hpp"
#include "support/random_chain.hpp"

namespace qerr {
namespace {

using testing::ChainMix;
using testing::Dice;

OperationalModel model_with_lengths(Dice& dice) {
  OperationalModel m{make_chain(testing::random_robot(dice, ChainMix{1 + dice.below(7)}), "", ""), {}, {}};
  m.transmission = testing::random_transmission(dice, m.chain, 1e-5, 1e-2, true);
  m.coordinates = {Coordinate::rz, Coordinate::x, Coordinate::ry,
                   Coordinate::z,  Coordinate::y, Coordinate::rx};
  m.lengths = {Coordinate::rxyz, Coordinate::xyz};
  m.frame = dice.chance(0.5) ? CoordinateFrame::tip : CoordinateFrame::base;
  if (dice.chance(0.5)) m.sources.push_back({.owner = 0, .mean = 1e-4, .half_width = 2e-4, .sigma = 1e-4});
  return m;
}

/// Positions of the components of a length in the model's coordinates.
std::vector<Eigen::Index> rows_of(Coordinate length) {
  return length == Coordinate::xyz ? std::vector<Eigen::Index>{1, 4, 3} : std::vector<Eigen::Index>{5, 2, 0};
}

/// Largest length over all corners of the box of encoders and sources, from the columns of the scalar bounds.
double largest_length(const OperationalModel& m, const Eigen::VectorXd& q, Coordinate length, double scale,
                      double gain) {
  OperationalModel without = m;
  without.sources.clear();
  const OperationalError e = operational_error(without, q);
  Eigen::MatrixXd generators = 0.5 * e.weighted;
  Eigen::VectorXd mean = e.mean;
  for (const IndependentError& s : m.sources) {
    OperationalModel unit = without;  // a joint's column is its error of 1 alone
    unit.sources = {{.owner = s.owner, .mean = 1, .half_width = 0, .sigma = 0}};
    const Eigen::VectorXd column = operational_error(unit, q).mean - e.mean;
    mean += s.mean * column;
    generators.conservativeResize(Eigen::NoChange, generators.cols() + 1);
    generators.rightCols<1>() = s.half_width * column;
  }
  double largest = 0;
  for (unsigned long bits = 0; bits < 1ul << generators.cols(); ++bits) {
    Eigen::VectorXd corner = gain * mean;
    for (Eigen::Index k = 0; k < generators.cols(); ++k)
      corner += (bits >> k & 1 ? scale : -scale) * generators.col(k);
    largest = std::max(largest, corner(rows_of(length)).norm());
  }
  return largest;
}

TEST(LengthErrors, AreThoseOfTheFarthestCornerAndTheSummedVariances) {
  Dice dice(8);
  for (int trial = 0; trial < 25; ++trial) {
    const OperationalModel m = model_with_lengths(dice);
    ErrorFigures asked;
    asked.filters = {norms(difference_filter(1000, 1)), norms(difference_filter(1000, 2))};
    BatchedError batched(m, asked);
    const FigureLayout& at = batched.figures();
    ASSERT_EQ(at.coordinates, 8u);
    AlignedNumbers q(m.chain.independent.size() * batch_size), figures(at.count * batch_size);
    for (std::size_t i = 0; i < q.size(); ++i) q[i] = dice.between(-3, 3);
    batched(q.data(), figures.data());
    for (std::size_t i = 0; i < batch_size; i += 13) {
      Eigen::VectorXd here(static_cast<Eigen::Index>(m.chain.independent.size()));
      for (Eigen::Index j = 0; j < here.size(); ++j)
        here[j] = q[static_cast<std::size_t>(j) * batch_size + i];
      const OperationalError e = operational_error(m, here);
      for (std::size_t l = 0; l < 2; ++l) {
        const auto figure = [&](std::size_t block) { return figures[(block + 6 + l) * batch_size + i]; };
        const double worst = largest_length(m, here, m.lengths[l], 1, 1);
        EXPECT_NEAR(figure(at.worst_case), worst, 1e-11 * worst);
        EXPECT_GE(figure(at.rigorous), worst * (1 - 1e-11));
        EXPECT_NEAR(figure(at.sigma), e.sigma(rows_of(m.lengths[l])).norm(), 1e-11 * worst);
        for (std::size_t f = 0; f < 2; ++f) {
          if (at.filtered_sigma == at.filtered_worst) continue;  // the position's times the norm
          const Norms& n = asked.filters[f];
          const double behind = largest_length(m, here, m.lengths[l], n.l1.upper, n.dc_gain);
          EXPECT_NEAR(figure(at.filtered_worst + f * 8), behind, 1e-11 * behind);
        }
      }
    }
  }
}

/// The exact error of every corner is within the rigorous bound of the length.
TEST(LengthErrors, RigorousBoundHoldsForExactKinematics) {
  Dice dice(9);
  for (int trial = 0; trial < 25; ++trial) {
    OperationalModel m = model_with_lengths(dice);
    m.sources.clear();
    BatchedError batched(m, {});
    const FigureLayout& at = batched.figures();
    AlignedNumbers q(m.chain.independent.size() * batch_size), figures(at.count * batch_size);
    for (std::size_t i = 0; i < q.size(); ++i) q[i] = dice.between(-3, 3);
    batched(q.data(), figures.data());
    const Eigen::VectorXd delta = resolutions(m.transmission), mean = mean_errors(m.transmission);
    for (std::size_t i = 0; i < batch_size; i += 31) {
      Eigen::VectorXd here(static_cast<Eigen::Index>(m.chain.independent.size()));
      for (Eigen::Index j = 0; j < here.size(); ++j)
        here[j] = q[static_cast<std::size_t>(j) * batch_size + i];
      const Eigen::Isometry3d truth = forward_kinematics(m.chain, here);
      for (int corner = 0; corner < 40; ++corner) {
        Eigen::VectorXd error = mean;
        for (Eigen::Index e = 0; e < error.size(); ++e)
          error[e] += (dice.chance(0.5) ? 0.5 : -0.5) * delta[e];
        const Eigen::Isometry3d estimate =
            forward_kinematics(m.chain, here + m.transmission.coupling * error);
        const double distance = (estimate.translation() - truth.translation()).norm();
        const double angle =
            Eigen::AngleAxisd(Eigen::Matrix3d(estimate.linear() * truth.linear().transpose())).angle();
        EXPECT_LE(distance, figures[(at.rigorous + 7) * batch_size + i] * (1 + 1e-12) + 1e-14);
        EXPECT_LE(angle, figures[(at.rigorous + 6) * batch_size + i] * (1 + 1e-9) + 1e-12);
      }
    }
  }
}

}  // namespace
}  // namespace qerr
