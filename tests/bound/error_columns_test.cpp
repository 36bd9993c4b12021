#include "bound/error_columns.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "qerr/bound/operational_error.hpp"
#include "qerr/filter/family.hpp"
#include "support/random_model.hpp"

namespace qerr {
namespace {

using testing::Dice;

/// The product of a row of columns and weights, at configuration i; `of` is applied to each entry.
template <class Function>
double product(const ErrorColumns& columns, std::size_t coordinate, std::size_t i,
               const Eigen::VectorXd& weights, Function of) {
  double sum = 0;
  for (std::size_t k = 0; k < columns.columns(); ++k)
    sum += of(columns.column(coordinate, k)[i]) * weights[static_cast<Eigen::Index>(k)];
  return sum;
}

double identity(double x) { return x; }
double magnitude(double x) { return std::abs(x); }
double square(double x) { return x * x; }

/// |difference| within the rounding of sums of this size.
bool same(double a, double b, double size) { return std::abs(a - b) <= 1e-12 * size + 1e-300; }

SignalMoments random_moments(Dice& dice, std::size_t count) {
  const auto n = static_cast<Eigen::Index>(count);
  SignalMoments m{Eigen::VectorXd::Zero(n), dice.vector(n, 0, 1e-3), Eigen::MatrixXd::Zero(n, n)};
  m.covariance.diagonal() = dice.vector(n, 0, 1e-6);
  return m;
}

RC_GTEST_PROP(ErrorColumns, AndWeightsGiveTheFiguresOfTheScalarFunctions, ()) {
  Dice dice(*rc::gen::arbitrary<std::uint64_t>());
  const std::size_t filters = dice.below(3);
  OperationalModel model = testing::random_model(dice, filters, dice.chance(0.5) ? 1 : 0);
  const std::size_t encoders = model.transmission.encoders.size(), m = model.coordinates.size();
  if (dice.chance(0.3)) {
    model.along_motion = {random_moments(dice, encoders), random_moments(dice, m), {}};
    for (std::size_t f = 0; f < filters; ++f) model.along_motion->filtered.push_back(random_moments(dice, m));
  }
  std::vector<Norms> all;
  for (std::size_t f = 0; f < filters; ++f)
    all.push_back(norms(difference_filter(1000, 1 + static_cast<int>(f))));
  Configurations configurations{.count = 1 + dice.below(130), .seed = 1 + dice.below(100), .ranges = {}};
  configurations.ranges.assign(encoders, {-3, 3});
  const ErrorColumns columns(model, model.sources, configurations, 1 + static_cast<unsigned>(dice.below(2)));
  const ErrorWeights w = error_weights(columns, model, all);
  RC_ASSERT(columns.configurations() == configurations.count);
  const Eigen::MatrixXd q = draw(configurations, 0, configurations.count);
  for (std::size_t i = 0; i < configurations.count; ++i) {
    const OperationalError e = operational_error(model, q.col(static_cast<Eigen::Index>(i)));
    if (e.cosine_of_pitch < 1e-3) continue;
    double remainder = w.remainder.position;
    for (std::size_t j = 0; j < columns.joints(); ++j)
      remainder += w.remainder.per_column[static_cast<Eigen::Index>(j)] * columns.norms(j)[i];
    for (std::size_t c = 0; c < m; ++c) {
      const auto row = static_cast<Eigen::Index>(c);
      const double size = e.worst_case.maxCoeff() / std::pow(e.cosine_of_pitch, 2) + 1e-3;
      const double half = product(columns, c, i, w.half_width, magnitude);
      const double mean = std::abs(product(columns, c, i, w.mean, identity));
      const double worst = half + mean + w.added_worst[row];
      RC_ASSERT(same(worst, e.worst_case[row], size));
      RC_ASSERT(same(std::sqrt(product(columns, c, i, w.variance, square) + w.added_variance[row]),
                     e.sigma[row], size));
      if (is_position(model.coordinates[c])) RC_ASSERT(same(worst + remainder, e.rigorous[row], size));
      OperationalModel ideal = model;  // derivative_error is without the error along a motion
      ideal.along_motion.reset();
      const OperationalError still = operational_error(ideal, q.col(static_cast<Eigen::Index>(i)));
      for (std::size_t f = 0; f < filters; ++f) {
        const Bounds b = derivative_error(still, row, all[f], sigma_ratios(model.sources, f, all[f].h2));
        const ErrorWeights::Filtered& behind = w.filtered[f];
        const double added = model.along_motion ? model.along_motion->filtered[f].peak[row] : 0;
        RC_ASSERT(same(behind.l1 * half + behind.dc_gain * mean + behind.added_worst[row],
                       b.worst_case + added, size * all[f].l1.upper));
        RC_ASSERT(same(std::sqrt(product(columns, c, i, behind.variance, square)), b.sigma,
                       size * all[f].l1.upper));
      }
    }
  }
}

// Every source enters at the column of its place, wherever it stands in the list.
TEST(ErrorColumns, ServeModelsWithOtherSources) {
  Dice dice(7);
  OperationalModel model = testing::random_model(dice, 0, 0);
  model.sources.clear();
  const std::size_t encoders = model.transmission.encoders.size();
  std::vector<IndependentError> sources;
  for (std::size_t e = 0; e < encoders; ++e)
    sources.push_back({IndependentError::Where::joint, e, 0, Eigen::Vector3d::Zero(), 0, 1e-4, 5e-5});
  Configurations configurations{.count = 10, .ranges = {}};
  configurations.ranges.assign(encoders, {-2, 2});
  const ErrorColumns columns(model, sources, configurations);
  const ErrorWeights without = error_weights(columns, model, {});
  model.sources = {sources.back()};
  const ErrorWeights with = error_weights(columns, model, {});
  const auto at = static_cast<Eigen::Index>(columns.column_of(sources.back()));
  EXPECT_NEAR(with.half_width[at] - without.half_width[at], 1e-4, 1e-18);
  EXPECT_EQ((with.half_width - without.half_width).cwiseAbs().sum(),
            std::abs(with.half_width[at] - without.half_width[at]));
  EXPECT_THROW(
      error_weights(ErrorColumns(model, {}, configurations),
                    [&] {
                      OperationalModel other = model;
                      other.sources = {{IndependentError::Where::origin, 0, 0, {0, 0, 1}, 0, 1e-3, 0}};
                      return other;
                    }(),
                    {}),
      std::logic_error);
}

}  // namespace
}  // namespace qerr
