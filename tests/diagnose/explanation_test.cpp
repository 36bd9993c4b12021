#include "diagnose/inference/explanation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/random.hpp"
#include "diagnose/inference/finding.hpp"
#include "diagnose/inference/remainder.hpp"
#include "diagnose/inference/scatter.hpp"
#include "diagnose/record/smooth_path.hpp"
#include "diagnose/search/residual_scan.hpp"

namespace qerr {

namespace {

constexpr double step = 1e-4, turn = 2 * std::numbers::pi;

double normal(std::uint64_t index, std::uint64_t stream) {
  const double u = unit_interval(random_bits(7, 2 * index, stream)),
               v = unit_interval(random_bits(7, 2 * index + 1, stream));
  return std::sqrt(-2 * std::log(1 - u)) * std::cos(turn * v);
}

/// An error of the reading: a function of row, time and angle [rad].
using Flaw = double (*)(std::size_t row, double time, double angle);

double none(std::size_t, double, double) { return 0; }

/// An oscillating joint; its encoder rounds the sum of the true angle and the error.
Evidence swing(Flaw flaw, double counts_per_period = 4, Eigen::Index n = 6000) {
  Evidence e;
  e.joint = "elbow";
  e.encoder = {step, Rounding::nearest, true, 10, counts_per_period};
  e.noise = 0.04 * step;
  e.interval = 1e-3;
  e.time = Eigen::ArrayXd::LinSpaced(n, 0, e.interval * static_cast<double>(n - 1));
  e.reference = 1.1 * (2.1 * e.time).sin() + 0.2 * (7.7 * e.time + 1).cos();
  e.measured.resize(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double seen = e.reference[k] + flaw(static_cast<std::size_t>(k), e.time[k], e.reference[k]);
    e.measured[k] = step * std::floor(seen / step + 0.5);
    e.reference[k] += e.noise * normal(static_cast<std::uint64_t>(k), 1);
  }
  const SmoothPath smooth = smooth_path(e.time, e.reference, 0);
  e.path = smooth.position;
  e.velocity = smooth.velocity;
  e.path_noise = smooth.residual_noise;
  e.direction = direction_of_motion(e.path, 10 * e.noise);
  return e;
}

Evidence rows(const Evidence& e) { return group_means(e, independent_rows(e, 1)); }

std::vector<std::string> names(const Selection& s) {
  std::vector<std::string> found;
  for (const Term& t : s.model.terms()) found.push_back(t.named() ? t.effect.type : "unnamed: " + t.unnamed);
  return found;
}

/// A record, its independent rows and what the search finds in it. Not copyable: each part refers to another.
struct Diagnosed {
  Evidence record;
  Sampling sampling;
  Selection selection;
  Scatter scatter;

  explicit Diagnosed(Evidence e)
      : record(std::move(e)),
        sampling(record, independent_rows(record, 1)),
        selection(selection_of(sampling, search_causes(record, 7))),
        scatter(scatter_of(sampling.evidence, selection.model, 0)) {}
  Diagnosed(const Diagnosed&) = delete;
  Diagnosed& operator=(const Diagnosed&) = delete;

  std::string remainder() const { return remainder_of(sampling.evidence, selection.model, scatter, 0).what; }
};

using Names = std::vector<std::string>;

TEST(IntervalLikelihood, HasTheDerivativesOfItsValue) {
  const Intervals edges{Eigen::Array4d(-0.2, -1.3, 0.4, -30), Eigen::Array4d(0.8, -0.3, 1.4, -29)};
  const Eigen::ArrayXd x = Eigen::Array4d(0.1, 0.3, 0.3, 0.5), sigma = Eigen::Array4d(0.5, 0.7, 1.1, 0.9);
  const auto value = [&](const Eigen::ArrayXd& u, double w) {  // x = u/w, sigma/w
    return interval_likelihood(edges, u / w, sigma / w).log_likelihood;
  };
  const IntervalLikelihood l = interval_likelihood(edges, x, sigma);
  constexpr double h = 1e-4;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const Eigen::ArrayXd by = h * Eigen::VectorXd::Unit(4, k).array();
    EXPECT_NEAR(l.score[k], (value(x + by, 1) - value(x - by, 1)) / (2 * h),
                1e-5 * (1 + std::abs(l.score[k])));
    EXPECT_NEAR(l.curvature[k], -(value(x + by, 1) - 2 * value(x, 1) + value(x - by, 1)) / (h * h),
                1e-4 * (1 + l.curvature[k]));
    EXPECT_NEAR(l.cross[k],
                -(value(x + by, 1 + h) - value(x - by, 1 + h) - value(x + by, 1 - h) + value(x - by, 1 - h)) /
                    (4 * h * h),
                1e-3 * (1 + std::abs(l.cross[k])));
  }
  EXPECT_NEAR(l.scale_score, (value(x, 1 + h) - value(x, 1 - h)) / (2 * h), 1e-4 * std::abs(l.scale_score));
  EXPECT_NEAR(l.scale_curvature, -(value(x, 1 + h) - 2 * value(x, 1) + value(x, 1 - h)) / (h * h),
              1e-3 * l.scale_curvature);
}

TEST(IntervalLikelihood, IsContinuousWhereItsLogarithmicFormBegins) {
  for (const double outliers : {0.0, 1e-80})
    for (const double side : {-1.0, 1.0}) {
      const auto at = [&](double sigmas) {
        const double edge = side * sigmas;
        const Intervals edges{Eigen::ArrayXd::Constant(1, side > 0 ? edge : edge - 1),
                              Eigen::ArrayXd::Constant(1, side > 0 ? edge + 1 : edge)};
        return interval_likelihood(edges, Eigen::ArrayXd::Zero(1), Eigen::ArrayXd::Ones(1), outliers, 10);
      };
      const IntervalLikelihood near = at(20 - 1e-12), beyond = at(20 + 1e-12);
      EXPECT_NEAR(near.log_likelihood, beyond.log_likelihood, 1e-7);
      EXPECT_NEAR(near.score[0], beyond.score[0], 1e-7 * std::abs(near.score[0]));
      EXPECT_NEAR(near.curvature[0], beyond.curvature[0], 1e-4 * near.curvature[0]);
      EXPECT_NEAR(near.outliers, beyond.outliers, 1e-7);
    }
}

TEST(Explanation, KeepsDerivedColumnsOfATermWhenThePathMoves) {
  // A latency of many counts moves the path, and the columns along the path are recomputed.
  const Evidence e = rows(swing([](std::size_t, double time, double angle) {
    return 0.01 * (1.1 * 2.1 * std::cos(2.1 * time) - 0.2 * 7.7 * std::sin(7.7 * time + 1)) +
           3 * step * std::sin(angle);
  }));
  const Term order = periodic_term(e, 2, false);
  const Eigen::ArrayXXd first = order.columns.leftCols(1);
  Explanation m(e);
  for (const Term& t : named_terms(e))
    if (t.effect.type == "latency") m.add(t);
  m.add(order);
  m.add(with_columns(order, first));
  m.fit();
  EXPECT_GT((m.terms()[1].columns.leftCols(1) - first).abs().maxCoeff(), 1e-3);
  ASSERT_EQ(m.terms()[2].size(), 1);
  EXPECT_TRUE((m.terms()[2].columns == first).all());
  EXPECT_FALSE(m.terms()[2].reshaped || m.terms()[2].relinearized);
}

TEST(Explanation, EstimatesAnOffsetBetterThanTheMeanOfTheCounts) {
  const Evidence e = rows(swing([](std::size_t, double, double) { return 0.37 * step; }));
  Explanation m(e);
  for (const Term& t : named_terms(e))
    if (t.effect.type == "offset") m.add(t);
  m.fit();
  EXPECT_NEAR(m.coefficients(0)[0], 0.37 * step, 0.004 * step);
  EXPECT_LT(m.noise(), 0.04 * step) << "less than the reference's own, since its path is smooth";
}

TEST(Explanation, FitsAResolverWithClippedSignals) {
  // The arctangent of clipped signals, independent of the effect's code.
  const Diagnosed d(swing(
      [](std::size_t, double, double q) {
        const double angle = turn * q / (1024 * step);
        const double s = std::clamp(std::sin(angle), -0.8, 0.8), c = std::clamp(std::cos(angle), -0.8, 0.8);
        return 1024 * step / turn * std::remainder(std::atan2(s, c) - angle, turn);
      },
      1024));
  const Selection& s = d.selection;
  ASSERT_EQ(names(s), Names{"subdivision_error"});
  ASSERT_EQ(s.model.coefficients(0).size(), 5);
  EXPECT_NEAR(s.model.coefficients(0)[4], 0.8, 1e-3);
  EXPECT_LT(s.model.coefficients(0).head(4).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(Search, FindsNothingInACleanRecord) { EXPECT_EQ(names(Diagnosed(swing(none)).selection), Names{}); }

TEST(Search, IdentifiesAStaircaseAsMissedCounts) {
  const Diagnosed d(
      swing([](std::size_t, double t, double) { return -step * ((t > 0.9) + (t > 2.2) + (t > 4.4)); }));
  EXPECT_EQ(names(d.selection), (Names{"missed_counts", "missed_counts", "missed_counts"}));
  for (std::size_t i = 0; i < d.selection.model.terms().size(); ++i)
    EXPECT_NEAR(d.selection.model.coefficients(i)[0], -1, 0.05);
}

TEST(Search, TakesAStepThatIsNoWholeCountForNoLossOfCounts) {
  const Diagnosed d(swing([](std::size_t, double t, double) { return 7.4 * step * (t > 2.2); }));
  ASSERT_EQ(d.selection.model.terms().size(), 1u);
  const Term& t = d.selection.model.terms()[0];
  EXPECT_FALSE(t.named());
  EXPECT_EQ(t.pattern, Shape::step);
  EXPECT_NEAR(t.effect.number("time"), 2.2, 2e-3);
  EXPECT_NEAR(d.selection.model.coefficients(0)[0], 7.4 * step, 0.05 * step);
}

TEST(Search, FindsAnIntegerOrderOfEitherShaft) {
  const Diagnosed of_encoder(
      swing([](std::size_t, double, double q) { return 0.8 * step * std::sin(30 * q + 1); }));
  ASSERT_EQ(names(of_encoder.selection), Names{"transmission_error"});
  EXPECT_EQ(of_encoder.selection.model.terms()[0].effect.number("order"), 3);
  EXPECT_EQ(of_encoder.selection.model.terms()[0].effect.choices.at("shaft"), "encoder");
  const Diagnosed of_joint(
      swing([](std::size_t, double, double q) { return 0.8 * step * std::sin(37 * q + 1); }));
  ASSERT_EQ(names(of_joint.selection), Names{"transmission_error"});
  EXPECT_EQ(of_joint.selection.model.terms()[0].effect.number("order"), 37);
  EXPECT_EQ(of_joint.selection.model.terms()[0].effect.choices.at("shaft"), "joint");
}

TEST(Search, NamesNoWholeOrdersForAFraction) {
  // Two whole orders on either side imitate it over few periods; and an amplitude that varies along the path
  // has whole orders that are no more than their neighbours.
  const Diagnosed fraction(
      swing([](std::size_t, double, double q) { return 3 * step * std::sin(4.4 * q + 1); }));
  ASSERT_EQ(fraction.selection.model.terms().size(), 1u);
  const Term& t = fraction.selection.model.terms()[0];
  EXPECT_EQ(t.pattern, Shape::order);
  EXPECT_NEAR(t.effect.number("order"), 4.4, 0.05);
  const Diagnosed varying(swing([](std::size_t, double time, double q) {
    return 3 * step * std::sin(1.3 * time) * std::sin(24.4 * q + 1);
  }));
  for (const std::string& name : names(varying.selection)) EXPECT_EQ(name.rfind("unnamed", 0), 0u) << name;
}

TEST(Search, FindsAConstantErrorAtRest) {
  Evidence e = swing(none);
  e.reference = e.path = Eigen::ArrayXd::Constant(e.rows(), 0.41 * step);
  e.measured.setConstant(7 * step);
  e.velocity = e.direction = Eigen::ArrayXd::Zero(e.rows());
  const FoundCauses found = search_causes(e, 1);
  ASSERT_EQ(found.chosen.size(), 1u);
  EXPECT_EQ(found.chosen[0].candidate.term->effect.type, "offset");
  EXPECT_NEAR(found.chosen[0].coefficients[0], 6.59 * step, 1e-12);
}

TEST(Search, FindsTheSameInAThinnedRecord) {
  Evidence e = swing([](std::size_t, double, double q) { return 2 * step * std::sin(q + 0.3); });
  const Eigen::Index copies = 30, n = e.rows();
  for (Eigen::ArrayXd* column : {&e.time, &e.reference, &e.measured, &e.path, &e.velocity, &e.direction}) {
    const Eigen::ArrayXd once = *column;
    column->resize(copies * n);
    for (Eigen::Index i = 0; i < copies; ++i) column->segment(i * n, n) = once;
  }
  e.time = Eigen::ArrayXd::LinSpaced(e.rows(), 0, e.interval * static_cast<double>(e.rows() - 1));
  const Evidence few = thinned(e, 1);
  EXPECT_EQ(few.rows(), 1 << 16);
  EXPECT_EQ(few.interval, e.interval);
  EXPECT_TRUE((few.time.tail(few.rows() - 1) > few.time.head(few.rows() - 1)).all());
  EXPECT_EQ(names(Diagnosed(few).selection), Names{"eccentricity"});
}

TEST(Search, ScansForNothingThatAModelCouldNotTakeIn) {
  const auto scanned = [](const Evidence& e) {
    const ErrorSamples samples = error_samples(e, 1, most_samples);
    const ErrorModel nothing(e, samples, {}, {}, {}, {});
    Scanned s;
    scan_residual(nothing, samples.error, s);
    return s;
  };
  const Scanned of_none = scanned(swing(none));
  EXPECT_TRUE(of_none.orders.empty() && of_none.lines.empty() && of_none.events.empty() &&
              of_none.places.empty());
  const Scanned of_line = scanned(
      swing([](std::size_t, double t, double) { return 0.15 * step * std::sin(turn * 17 * t + 0.2); }));
  ASSERT_FALSE(of_line.lines.empty());
  EXPECT_NEAR(of_line.lines[0].value, 17, 0.02);
}

TEST(Search, SeparatesLatencyFromPlay) {
  // Neither alone: each hides the other from a search that adds one term at a time.
  const Diagnosed d(swing([](std::size_t, double t, double) {
    const double v = 1.1 * 2.1 * std::cos(2.1 * t) - 0.2 * 7.7 * std::sin(7.7 * t + 1);
    return -1e-4 * v + 1.5 * step * (v > 0 ? 1 : -1);
  }));
  Names found = names(d.selection);
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, (Names{"backlash", "latency"}));
}

TEST(Search, DescribesADamagedToothAsABump) {
  const Diagnosed d(swing([](std::size_t, double, double q) {
    return 4 * step * std::exp(-0.5 * std::pow((q - 0.3) / 0.05, 2));
  }));
  ASSERT_EQ(d.selection.model.terms().size(), 1u);
  const Term& t = d.selection.model.terms()[0];
  EXPECT_EQ(t.pattern, Shape::bump);
  EXPECT_NEAR(t.effect.number("angle"), 0.3, 0.01);
  EXPECT_NEAR(t.effect.number("width"), 0.05, 0.005);
}

TEST(Search, LeavesASlowVariationUnidentified) {
  const Diagnosed d(swing([](std::size_t, double t, double) {
    return 3 * step * (std::sin(2.9 * t) + 0.6 * std::sin(5.1 * t + 1) + 0.4 * std::cos(8.3 * t));
  }));
  ASSERT_FALSE(d.selection.model.terms().empty());
  for (const Term& t : d.selection.model.terms()) EXPECT_FALSE(t.named()) << t.effect.type;
}

TEST(Search, FindsNoOrdersForAJointAtRest) {
  Evidence e = swing(none);
  e.reference = e.path = Eigen::ArrayXd::Constant(e.rows(), 0.41 * step);
  for (Eigen::Index k = 0; k < e.rows(); ++k)
    e.reference[k] += e.noise * normal(static_cast<std::uint64_t>(k), 5);
  e.measured.setZero();
  e.velocity = e.direction = Eigen::ArrayXd::Zero(e.rows());
  EXPECT_TRUE(e.is_stationary());
  EXPECT_EQ(names(Diagnosed(e).selection), Names{});
}

// An error that the model lacks gives all scores one sign: the sums over b blocks of n rows have n/b times
// the variance of independent ones. Fewer than four blocks of eight rows tell nothing.
TEST(Explanation, InflatesTheVarianceOfCorrelatedScoresOfThirtyTwoRowsOrMore) {
  const auto inflation = [](Eigen::Index rows) {
    const Evidence e = swing([](std::size_t, double, double) { return 3 * step; }, 4, rows);
    return Explanation(e).variance_inflation(Eigen::ArrayXXd::Ones(rows, 1));
  };
  EXPECT_EQ(inflation(31), 1);
  EXPECT_GT(inflation(32), 4);
  EXPECT_LE(inflation(32), 8);
}

TEST(Scatter, FindsNoiseAndJitterTogether) {
  const auto error = [](std::size_t row, double time, double) {
    const double v = 1.1 * 2.1 * std::cos(2.1 * time) - 0.2 * 7.7 * std::sin(7.7 * time + 1);
    return 0.6 * step * normal(row, 2) + 5e-5 * v * normal(row, 3);
  };
  const Diagnosed d(swing(error));
  Names found;
  for (const ScatterCause& c : d.scatter.causes) found.push_back(c.effect.type);
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, (Names{"noise", "timing_jitter"}));
}

TEST(Scatter, IsNoiseIfStationaryAndUnidentifiedOtherwise) {
  const Diagnosed same(swing([](std::size_t row, double, double) { return 0.8 * step * normal(row, 2); }));
  ASSERT_EQ(same.scatter.causes.size(), 1u);
  const ScatterCause& noise = same.scatter.causes[0];
  EXPECT_EQ(noise.effect.type, "noise");
  EXPECT_NEAR(noise.effect.number("sigma"), 0.8 * step, 0.8 * step * noise.relative_error + 0.01 * step);
  EXPECT_EQ(same.remainder(), "");
  const Diagnosed sector(swing([](std::size_t row, double, double q) {
    return std::abs(q - 0.4) < 0.2 ? 3 * step * normal(row, 2) : 0;
  }));
  EXPECT_TRUE(sector.scatter.causes.empty());
  EXPECT_NE(sector.remainder(), "");
}

TEST(EdgePattern, IsThatOfTheDisplacedEdges) {
  // Edge k, between the counts k - 1 and k, is displaced by an amount that repeats every four counts.
  constexpr std::array<double, 4> edges{0.2, -0.1, 0.05, -0.15};
  Evidence e = swing(none);
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    double count = std::round(e.path[k] / step);
    const auto edge = [&](double n) {
      return n - 0.5 + edges[static_cast<std::size_t>(n - 4 * std::floor(n / 4))];
    };
    const double position = e.path[k] / step;
    if (position < edge(count)) --count;
    if (position >= edge(count + 1)) ++count;
    e.measured[k] = count * step;
  }
  const Diagnosed d(std::move(e));
  EXPECT_LT(d.scatter.pattern.p_value, 1e-6);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(d.scatter.pattern.displacement[i], edges[i], 0.03) << i;
  // Odd edges are 0.25 counts before even ones; the stated 95 % interval may miss that by its own width.
  ASSERT_EQ(d.scatter.causes.size(), 1u);
  const double relative_error = d.scatter.causes[0].relative_error;
  EXPECT_LT(relative_error, 0.1);
  EXPECT_NEAR(std::abs(d.scatter.pattern.alternating), 0.25, 2 * relative_error * 0.25);
  const Diagnosed clean(swing(none));
  EXPECT_GT(clean.scatter.pattern.p_value, 1e-4);
}

}  // namespace

}  // namespace qerr
