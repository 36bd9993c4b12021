#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "diagnose/inference/remainder.hpp"
#include "diagnose/inference/scatter.hpp"
#include "support/fit_record.hpp"
#include "support/record_figures.hpp"

/// Every figure of scatter, displaced edges and remainders of small synthetic records, in which the path is
/// known and no search chooses terms.
namespace qerr {
namespace {

using testing::CountsAdded;
using testing::Dice;
using testing::FitSetting;
using testing::normal_deviate;
using testing::record_of_fit;
using testing::RecordFigures;

/// 1e-6 of each: the last step of a fit may differ between compilers.
const testing::Measured& figures_of_scatter() {
  static const testing::Measured all("scatter_figures.csv", 1e-6);
  return all;
}

/// The addition that makes a counter with displaced edges of a path and of noise.
double with_displaced_edges(double position, const std::vector<double>& edges) {
  double count = std::round(position);
  const auto edge = [&](double n) {
    return n - 0.5 + edges[static_cast<std::size_t>(n - 4 * std::floor(n / 4))];
  };
  if (position < edge(count)) --count;
  if (position >= edge(count + 1)) ++count;
  return count - position;
}

struct ScatterRecord {
  const char* name;
  CountsAdded added;
  double unnamed = 0;  // of uncatalogued terms [counts]
};

std::vector<ScatterRecord> scatter_records() {
  const auto noise = [](double size) {
    return [size](Dice& dice, const Evidence&, Eigen::Index) { return size * normal_deviate(dice); };
  };
  const auto jitter = [](double size) {
    return [size](Dice& dice, const Evidence& e, Eigen::Index k) {
      return size * e.velocity[k] * normal_deviate(dice);
    };
  };
  const auto edges = [](std::vector<double> displaced, double size) {
    return [=](Dice& dice, const Evidence& e, Eigen::Index k) {
      const double position = e.path[k] / e.step() + size * normal_deviate(dice);
      return with_displaced_edges(position, displaced) + position - e.path[k] / e.step();
    };
  };
  return {
      {"nothing", noise(0)},
      {"hardly noise", noise(0.13)},
      {"little noise", noise(0.25)},
      {"noise", noise(0.7)},
      {"much noise", noise(6)},
      {"noise below a misfit", noise(0.7), 0.8},
      {"noise above a misfit", noise(0.9), 0.8},
      {"hardly jitter", jitter(0.04)},
      {"jitter", jitter(0.2)},
      {"much jitter", jitter(1.5)},
      {"both",
       [](Dice& dice, const Evidence& e, Eigen::Index k) {
         const double still = 0.5 * normal_deviate(dice);
         return still + 0.25 * e.velocity[k] * normal_deviate(dice);
       }},
      {"both; more noise",
       [](Dice& dice, const Evidence& e, Eigen::Index k) {
         const double still = 1.2 * normal_deviate(dice);
         return still + 0.2 * e.velocity[k] * normal_deviate(dice);
       }},
      {"alternating edges", edges({0.15, -0.15, 0.15, -0.15}, 0)},
      {"edges", edges({0.2, -0.1, 0.05, -0.15}, 0)},
      {"edges of period four", edges({0.2, 0, -0.2, 0}, 0)},
      {"edges and noise", edges({-0.2, 0.2, -0.2, 0.2}, 0.4)},
      {"small edges", edges({0.03, -0.03, 0.03, -0.03}, 0)},
      {"noise at a place",
       [](Dice& dice, const Evidence& e, Eigen::Index k) {
         const double size = std::abs(e.path[k] - 0.4) < 0.2 ? 3 : 0.3;
         return size * normal_deviate(dice);
       }},
      {"noise for a while",
       [](Dice& dice, const Evidence& e, Eigen::Index k) {
         const double size = std::abs(e.time[k] - 1.5) < 0.2 ? 4 : 0.2;
         return size * normal_deviate(dice);
       }},
      {"uneven noise",
       [](Dice& dice, const Evidence& e, Eigen::Index k) {
         const double size = 1 + 0.4 * std::sin(e.path[k]);
         return size * normal_deviate(dice);
       }},
      {"a wave", [](Dice&, const Evidence& e, Eigen::Index k) { return 3 * std::sin(1.3 * e.time[k]); }},
      {"a wave for a while",
       [](Dice&, const Evidence& e, Eigen::Index k) {
         return e.time[k] < 0.4 ? 6 * std::sin(15 * e.time[k]) : 0;
       }},
      {"a bump", [](Dice&, const Evidence& e,
                    Eigen::Index k) { return 5 * std::exp(-std::pow((e.path[k] - 0.4) / 0.2, 2)); }},
      {"single readings",
       [](Dice& dice, const Evidence&, Eigen::Index k) {
         return k == 310 || k == 700 ? 40 : 0.1 * normal_deviate(dice);
       }},
      {"heavy tails",
       [](Dice& dice, const Evidence&, Eigen::Index) {
         const double size = dice.chance(0.04) ? 5 : 0.3;
         return size * normal_deviate(dice);
       }},
  };
}

constexpr FitSetting scatter_settings[]{
    {.name = "nearest", .rows = 1300},
    {.name = "of poses", .rounding = Rounding::down, .ordered = false, .rows = 1300},
    {.name = "free zero", .zero_known = false, .rows = 1100},
    {.name = "short", .rows = 470},
};

void expect_scatter(const RecordFigures& figure, const Evidence& e, const Explanation& m, double unnamed) {
  const Scatter s = scatter_of(e, m, unnamed);
  figure("size", s.size);
  const Eigen::ArrayXd ramp = Eigen::ArrayXd::LinSpaced(e.rows(), 0, 1);
  figure("expected", s.expected.mean());
  figure("expected along the record", (s.expected * ramp).mean());
  figure("log p of the edges", std::log(std::max(s.pattern.p_value, 1e-300)));
  if (s.pattern.alternating_error > 0) {
    figure("largest displacement", s.pattern.largest());
    figure("alternating", s.pattern.alternating);
    figure("alternating error", s.pattern.alternating_error);
    const Intervals moved = displaced(e, m, s.pattern);
    figure("lower edges", std::sqrt((moved.lower * ramp).square().mean()));
    figure("upper edges", std::sqrt((moved.upper * ramp).square().mean()));
  }
  figure("causes", static_cast<double>(s.causes.size()));
  for (const ScatterCause& c : s.causes) {
    for (const auto& [name, value] : c.effect.numbers) figure(c.effect.type + ' ' + name, value);
    figure(c.effect.type + " relative error", c.relative_error);
    figure(c.effect.type + " rms", c.rms);
    figure(c.effect.type + " log p", std::log(std::max(c.p_value, 1e-300)));
    if (c.alternative)
      for (const auto& [name, value] : c.alternative->numbers)
        figure("or " + c.alternative->type + ' ' + name, value);
  }
  const Remainder r = remainder_of(e, m, s, unnamed);
  figure("ratio of the remainder", r.ratio);
  figure("remainder " + r.what + ' ' + std::to_string(static_cast<int>(r.shape)), r.size);
}

TEST(ScatterFigures, OfScatterAndRemaindersAreAsMeasured) {
  for (const FitSetting& s : scatter_settings) {
    std::uint64_t seed = 500;
    for (const ScatterRecord& r : scatter_records()) {
      Dice dice(++seed);
      const Evidence e = record_of_fit(dice, s, r.added);
      const Explanation m(e);
      const RecordFigures figure(figures_of_scatter(), std::string(s.name) + "; " + r.name);
      expect_scatter(figure, e, m, r.unnamed * e.step());
    }
  }
}

TEST(ScatterFigures, OfARecordAtRestAreAsMeasured) {
  for (const double size : {0.0, 0.4, 1.5}) {
    Dice dice(77);
    Evidence e = record_of_fit(dice, {.name = "", .rows = 700}, [&](Dice& d, const Evidence&, Eigen::Index) {
      return size * normal_deviate(d);
    });
    const Eigen::ArrayXd errors = e.measured - e.path;
    e.path.setConstant(0.37 * e.step());
    e.velocity.setZero();
    e.direction.setZero();
    for (Eigen::Index k = 0; k < e.rows(); ++k) e.measured[k] = quantize(e.encoder, e.path[k] + errors[k]);
    const RecordFigures figure(figures_of_scatter(), "rest " + std::to_string(static_cast<int>(10 * size)));
    expect_scatter(figure, e, Explanation(e), 0);
  }
}

}  // namespace
}  // namespace qerr
