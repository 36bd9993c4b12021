#include "design/encoder_choice.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace qerr {
namespace {

/// A random problem that owns its columns. Weights fall with the price, as those of encoders do, but for some
/// options that are dearer and no finer.
class RandomProblem {
 public:
  explicit RandomProblem(std::uint64_t seed) : draw_(seed) {
    const std::size_t joints = 1 + index(5);
    problem.configurations = 1 + index(400);
    for (std::size_t j = 0; j < joints; ++j) {
      const std::size_t options = 1 + index(7);
      auto& prices = problem.prices.emplace_back();
      for (std::size_t o = 0; o < options; ++o) prices.push_back(static_cast<std::int64_t>(index(12)));
      std::sort(prices.begin(), prices.end());
    }
    const std::size_t figures = 1 + index(4);
    for (std::size_t f = 0; f < figures; ++f) problem.figures.push_back(figure());
  }

  /// All choices that meet the limits, in order.
  std::vector<OptionChoice> enumerated(const std::vector<double>& limits, std::int64_t most) const {
    std::vector<std::pair<std::int64_t, OptionChoice>> met;
    OptionChoice choice(problem.joints());
    while (true) {
      bool all = price_of(problem, choice) <= most;
      for (std::size_t f = 0; f < problem.figures.size() && all; ++f)
        all = figure_value(problem.figures[f], weights_of(problem.figures[f], choice),
                           problem.configurations) <= limits[f];
      if (all) met.emplace_back(price_of(problem, choice), choice);
      std::size_t j = 0;
      while (j < choice.size() && ++choice[j] == problem.prices[j].size()) choice[j++] = 0;
      if (j == choice.size()) break;
    }
    std::sort(met.begin(), met.end());
    std::vector<OptionChoice> list;
    for (auto& [price, one] : met) list.push_back(std::move(one));
    return list;
  }

  /// Limits between the figures of random choices: no value is within rounding of them.
  std::vector<double> limits() {
    std::vector<double> list;
    for (const ChoiceFigure& f : problem.figures) {
      OptionChoice a, b;
      for (const auto& prices : problem.prices) {
        a.push_back(index(prices.size()));
        b.push_back(prices.size() - 1 - index(std::min<std::size_t>(2, prices.size())));
      }
      const double x = figure_value(f, weights_of(f, a), problem.configurations);
      const double y = figure_value(f, weights_of(f, b), problem.configurations);
      list.push_back((0.3 + 0.7 * uniform()) * x + 0.6 * y + 1e-3 * uniform());
    }
    return list;
  }

  std::size_t index(std::size_t count) { return static_cast<std::size_t>(draw_() % count); }
  double uniform() { return std::uniform_real_distribution<>()(draw_); }

  ChoiceProblem problem;

 private:
  const double* column() {
    auto& values = columns_.emplace_back(std::make_unique<std::vector<double>>());
    const double scale = std::exp(2 * uniform());
    for (std::size_t i = 0; i < problem.configurations; ++i) values->push_back(scale * uniform() * uniform());
    return values->data();
  }

  ChoiceFigure figure() {
    using Over = ChoiceFigure::Over;
    ChoiceFigure f;
    f.over =
        std::array{Over::largest, Over::percentile, Over::mean, Over::least}[index(8) < 7 ? index(3) : 3];
    f.percentile = std::array{0.99, 0.95, 0.5}[index(3)];
    f.root = index(2) == 0;
    const std::size_t sums = f.root ? 1 : 1 + index(2);
    for (std::size_t s = 0; s < sums; ++s) {
      WeightedSum& sum = f.sums.emplace_back();
      sum.added = index(3) == 0 ? 0.1 * uniform() : 0;
      for (std::size_t j = 0; j < problem.joints(); ++j)
        for (std::size_t k = 0; k < 1 + index(6) / 5; ++k) {
          WeightedColumn c{j, column(), {}};
          double weight = 4;
          for (std::size_t o = 0; o < problem.prices[j].size(); ++o) {
            weight *= index(5) == 0 ? 1.3 : 0.2 + 0.7 * uniform();
            c.weights.push_back(weight);
          }
          sum.columns.push_back(std::move(c));
        }
    }
    return f;
  }

  std::mt19937_64 draw_;
  std::vector<std::unique_ptr<std::vector<double>>> columns_;
};

TEST(EncoderChoice, BestAndRunnerUpAreThoseOfEnumeration) {
  int feasible = 0, infeasible = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    RandomProblem random(seed);
    EncoderSearch search(random.problem);
    // Cuts of one search must not spoil the next one, whose limits differ.
    for (int repeat = 0; repeat < 3; ++repeat) {
      ChoiceRequest request;
      request.limits = random.limits();
      if (random.index(3) == 0) request.limits[random.index(request.limits.size())] = INFINITY;
      if (random.index(4) == 0) request.most = static_cast<std::int64_t>(random.index(40));
      const std::vector<OptionChoice> all = random.enumerated(request.limits, request.most);
      const ChoiceResult result = search.find(request);
      ASSERT_TRUE(result.proven);
      ASSERT_EQ(result.best.size(), std::min<std::size_t>(2, all.size())) << "seed " << seed << '/' << repeat;
      for (std::size_t i = 0; i < result.best.size(); ++i)
        ASSERT_EQ(result.best[i], all[i]) << "seed " << seed << '/' << repeat << " place " << i;
      (all.empty() ? infeasible : feasible)++;
    }
  }
  EXPECT_GT(feasible, 150);
  EXPECT_GT(infeasible, 50);
}

TEST(EncoderChoice, AKnownOrExcludedChoiceDoesNotChangeTheOrder) {
  for (std::uint64_t seed = 1000; seed < 1150; ++seed) {
    RandomProblem random(seed);
    EncoderSearch search(random.problem);
    ChoiceRequest request;
    request.limits = random.limits();
    const std::vector<OptionChoice> all = random.enumerated(request.limits, request.most);
    if (all.size() < 3) continue;
    request.known = {all.back(), all[1]};
    EXPECT_EQ(search.find(request).best, (std::vector{all[0], all[1]})) << "seed " << seed;
    request.excluded = {all[0]};
    EXPECT_EQ(search.find(request).best, (std::vector{all[1], all[2]})) << "seed " << seed;
  }
}

TEST(EncoderChoice, AJudgeDecidesWhatItsLowerBoundDoesNot) {
  for (std::uint64_t seed = 2000; seed < 2100; ++seed) {
    RandomProblem random(seed);
    // The judge's figure is half as large again as the sums say, and the other figures are its as well.
    ChoiceProblem judged = random.problem;
    judged.figures[0].bound = true;
    judged.judge = [&](const OptionChoice& choice, const std::vector<double>& limits) {
      const ChoiceFigure& f = random.problem.figures[0];
      const double value = figure_value(f, weights_of(f, choice), random.problem.configurations);
      return ChoiceProblem::Verdict{1.5 * value <= limits[0]};
    };
    std::vector<double> limits = random.limits();
    ChoiceRequest request;
    request.limits = limits;
    request.limits[0] *= 1.5;
    const std::vector<OptionChoice> all = random.enumerated(limits, request.most);
    const ChoiceResult result = EncoderSearch(judged).find(request);
    ASSERT_EQ(result.best.size(), std::min<std::size_t>(2, all.size())) << "seed " << seed;
    for (std::size_t i = 0; i < result.best.size(); ++i) EXPECT_EQ(result.best[i], all[i]) << "seed " << seed;
  }
}

TEST(EncoderChoice, AFigureThatOnlyTheJudgeKnowsLeavesEveryOption) {
  // Such as the error of a closed loop of encoders with an accuracy: a dearer option may be the better one.
  for (std::uint64_t seed = 2200; seed < 2300; ++seed) {
    RandomProblem random(seed);
    ChoiceProblem judged = random.problem;
    judged.figures = {ChoiceFigure{}};
    judged.judge = [&](const OptionChoice& choice, const std::vector<double>& limits) {
      const ChoiceFigure& f = random.problem.figures[0];
      return ChoiceProblem::Verdict{figure_value(f, weights_of(f, choice), random.problem.configurations) <=
                                    limits[0]};
    };
    std::vector<double> limits = random.limits();
    std::fill(limits.begin() + 1, limits.end(), INFINITY);
    ChoiceRequest request;
    request.limits = {limits[0]};
    const std::vector<OptionChoice> all = random.enumerated(limits, request.most);
    const ChoiceResult result = EncoderSearch(judged).find(request);
    ASSERT_EQ(result.best.size(), std::min<std::size_t>(2, all.size())) << "seed " << seed;
    for (std::size_t i = 0; i < result.best.size(); ++i) EXPECT_EQ(result.best[i], all[i]) << "seed " << seed;
  }
}

TEST(EncoderChoice, TheBoundOfAnEndedSearchIsNotAboveTheOptimum) {
  int ended = 0;
  for (std::uint64_t seed = 3000; seed < 3200; ++seed) {
    RandomProblem random(seed);
    ChoiceRequest request;
    request.limits = random.limits();
    const std::vector<OptionChoice> all = random.enumerated(request.limits, request.most);
    if (all.empty()) continue;
    request.work = 1 + static_cast<double>(random.index(20000));
    const ChoiceResult result = EncoderSearch(random.problem).find(request);
    if (result.proven) {
      EXPECT_EQ(result.best.front(), all.front());
      continue;
    }
    ++ended;
    EXPECT_LE(result.bound, price_of(random.problem, all.front())) << "seed " << seed;
    for (const OptionChoice& choice : result.best)
      EXPECT_NE(std::find(all.begin(), all.end(), choice), all.end()) << "seed " << seed;
  }
  EXPECT_GT(ended, 20);
}

TEST(EncoderChoice, ManyCombinationsEndWithACloseBound) {
  // 15 joints x 100 options, 1e30 choices.
  std::vector<double> ones(50, 1.0);
  ChoiceProblem problem;
  problem.configurations = ones.size();
  ChoiceFigure f;
  f.root = true;
  f.sums.emplace_back();
  for (std::size_t j = 0; j < 15; ++j) {
    problem.prices.emplace_back();
    WeightedColumn c{j, ones.data(), {}};
    for (int o = 0; o < 100; ++o) {
      problem.prices.back().push_back(10 * o + (o * o) / 10);
      c.weights.push_back(std::pow(0.9, o));
    }
    f.sums[0].columns.push_back(c);
  }
  problem.figures.push_back(f);
  ChoiceRequest request;
  request.limits = {0.7};
  request.wanted = 1;
  request.work = 1e9;
  const ChoiceResult result = EncoderSearch(problem).find(request);
  ASSERT_EQ(result.best.size(), 1u);
  RecordProperty("bound", std::to_string(result.bound));
  RecordProperty("price", std::to_string(price_of(problem, result.best[0])));
  const double value = figure_value(f, weights_of(f, result.best[0]), ones.size());
  EXPECT_LE(value, 0.7);
  if (result.proven) return;
  EXPECT_GE(result.bound, 0.98 * static_cast<double>(price_of(problem, result.best[0])));
}

}  // namespace
}  // namespace qerr
