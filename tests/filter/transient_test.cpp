#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "filter/norms/autocorrelation.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {
namespace {

/// The paper's recursion (35), (38) for a filter in controller canonical form.
std::vector<double> covariance_recursion(std::vector<double> b, std::vector<double> a, int count) {
  const auto order = static_cast<Eigen::Index>(std::max(a.size(), b.size())) - 1;
  b.resize(static_cast<std::size_t>(order) + 1);
  a.resize(static_cast<std::size_t>(order) + 1);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(order, order), S = A;
  Eigen::VectorXd B = Eigen::VectorXd::Unit(order, 0);
  Eigen::RowVectorXd C(order);
  for (Eigen::Index i = 0; i < order; ++i) {
    const auto next = static_cast<std::size_t>(i) + 1;
    A(0, i) = -a[next];
    if (i > 0) A(i, i - 1) = 1;
    C[i] = b[next] - a[next] * b[0];
  }
  std::vector<double> sigma;
  for (int k = 0; k < count; ++k) {
    sigma.push_back(std::sqrt((C * S * C.transpose())(0, 0) + b[0] * b[0]));
    S = A * S * A.transpose() + B * B.transpose();
  }
  return sigma;
}

TEST(NoiseTransient, IsThePapersCovarianceRecursion) {
  const double p = std::exp(-0.1 * std::numbers::pi);
  const std::pair<std::vector<double>, std::vector<double>> filters[] = {
      {{(1 - p) * 1000, -(1 - p) * 1000}, {1, -p}},
      {{(1 - p) * (1 - p) * 1000, -(1 - p) * (1 - p) * 1000}, {1, -2 * p, p * p}},
      {{2, 1}, {1, 0.2, 0.5}},
      {{1, -2.841, 2.875, -1.004}, {1, -2.417, 2.003, -0.5488}},
      {{0.5, 0.25, -1, 3}, {1}}};
  for (const auto& [b, a] : filters) {
    const Filter filter = filter_from_coefficients(b, a, 1000, 1);
    const std::vector<double> found = noise_transient(filter, 300),
                              expected = covariance_recursion(b, a, 300);
    for (std::size_t k = 0; k < found.size(); ++k) EXPECT_NEAR(found[k] / expected[k], 1, 1e-11) << k;
  }
}

TEST(NoiseTransient, IncreasesTowardsTheH2Norm) {
  for (const double cutoff : {1., 50., 300.})
    for (const FilterFamily& family : filter_families())
      if (family.name == "butterworth") {
        const Filter filter = family.design({1, 1000, {{"order", 3}, {"cutoff", cutoff}}, {}, {}});
        const std::vector<double> sigma = noise_transient(filter, 20000);
        EXPECT_TRUE(std::is_sorted(sigma.begin(), sigma.end()));
        EXPECT_NEAR(sigma.back() / h2_norm(filter), 1, 1e-13);
      }
}

TEST(NoiseRiseTime, IsTheFirstSampleAtTheFraction) {
  // h_k = (1 - p) p^k: sigma_k^2 = (1 - p)/(1 + p) (1 - p^(2 k + 2)).
  const double p = 0.999;
  const Filter filter = filter_from_coefficients({1 - p}, {1, -p}, 500, 0);
  for (const double fraction : {0.5, 0.99, 0.999}) {
    const double k = std::ceil(std::log(1 - fraction * fraction) / (2 * std::log(p)) - 1);
    EXPECT_DOUBLE_EQ(*noise_rise_time(filter, fraction), k / 500);
  }
  EXPECT_DOUBLE_EQ(*noise_rise_time(difference_filter(1000, 1), 0.9), 1e-3);
  EXPECT_FALSE(noise_rise_time(filter_from_coefficients({1e-9}, {1, -1 + 1e-9}, 1000, 0)));
}

}  // namespace
}  // namespace qerr
