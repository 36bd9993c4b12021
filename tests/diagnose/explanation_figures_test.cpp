#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "diagnose/inference/explanation.hpp"
#include "diagnose/inference/found_parameters.hpp"
#include "diagnose/inference/remainder.hpp"
#include "diagnose/inference/scatter.hpp"
#include "diagnose/inference/selection.hpp"
#include "diagnose/terms/unnamed_terms.hpp"
#include "support/measured.hpp"
#include "support/random_chain.hpp"

/// Every figure of fits, intervals, scatter and remainders of small synthetic records, in which the path is
/// known and no search chooses the terms.
namespace qerr {
namespace {

using testing::Dice;

/// Of a record, by name. 1e-6 of each: the last step of a fit may differ between compilers.
class FiguresOfAFit {
 public:
  explicit FiguresOfAFit(std::string record) : record_(std::move(record)) {}
  ~FiguresOfAFit() { measured().expect_all_met(record_ + ','); }
  FiguresOfAFit(const FiguresOfAFit&) = delete;
  FiguresOfAFit& operator=(const FiguresOfAFit&) = delete;

  void operator()(const std::string& figure, double value) const {
    measured().expect(record_ + ',' + figure, value);
  }

 private:
  static const testing::Measured& measured() {
    static const testing::Measured all("explanation_figures.csv", 1e-6);
    return all;
  }

  std::string record_;
};

double deviate(Dice& dice) {
  const double radius = std::sqrt(-2 * std::log(dice.between(1e-12, 1)));
  return radius * std::cos(2 * std::numbers::pi * dice.between(0, 1));
}

/// What the encoder adds to the angle at a row [counts].
using Addition = std::function<double(Dice&, const Evidence&, Eigen::Index row)>;

struct Setting {
  const char* name;
  Rounding rounding = Rounding::nearest;
  bool zero_known = true, random = false, ordered = true;
  bool accelerations = false;
  double shaft_ratio = 7, counts_per_period = 4;
  Eigen::Index rows = 900;
};

Evidence recorded(Dice& dice, const Setting& s, const Addition& added) {
  Evidence e;
  e.joint = "arm";
  e.encoder = {1.5e-3, s.rounding, s.zero_known, s.shaft_ratio, s.counts_per_period};
  const double step = e.step();
  e.ordered = s.ordered;
  e.interval = s.ordered ? 4e-3 : 0;
  e.time = Eigen::ArrayXd::LinSpaced(s.rows, 0, 4e-3 * static_cast<double>(s.rows - 1));
  const double phase = dice.between(0, 6);
  e.path = 2.4 * (2.9 * e.time + phase).sin() + 0.1 * (7.7 * e.time + 1).cos();
  e.velocity = 2.4 * 2.9 * (2.9 * e.time + phase).cos() - 0.1 * 7.7 * (7.7 * e.time + 1).sin();
  if (s.accelerations) e.acceleration = -2.9 * 2.9 * 2.4 * (2.9 * e.time + phase).sin();
  e.direction = (e.velocity > 0).select(Eigen::ArrayXd::Ones(s.rows), -Eigen::ArrayXd::Ones(s.rows));
  e.effort = (1.7 * e.time + 0.3).sin();
  e.temperature = 3 * (1 - (-0.6 * e.time).exp());
  e.noise = 0.05 * step;
  e.path_noise = 0.02 * step;
  if (s.random) e.random_sigma.resize(s.rows);
  e.reference.resize(s.rows);
  e.measured.resize(s.rows);
  for (Eigen::Index k = 0; k < s.rows; ++k) {
    e.reference[k] = e.path[k] + e.noise * deviate(dice);
    double seen = e.path[k] + step * added(dice, e, k);
    if (s.random) {
      e.random_sigma[k] = dice.between(0.1, 0.5) * step;
      seen += e.random_sigma[k] * deviate(dice);
    }
    e.measured[k] = quantize(e.encoder, seen);
  }
  return e;
}

/// A sum of several effects and noise: nothing is exactly zero.
double mixed(Dice& dice, const Evidence& e, Eigen::Index k) {
  const double q = e.path[k], t = e.time[k], v = e.velocity[k];
  const double slow = 0.3 + 1.4 * q + 0.9 * std::sin(2 * q + 0.5) + 0.6 * std::sin(7 * q - 1) + 0.8 * v;
  const double lost = t > 1.9 ? -2 : 0, warm = 1.1 * (1 - std::exp(-t / 0.9));
  const double far = dice.chance(0.01) ? 9 : 0;
  return slow + lost + warm + 0.4 * e.direction[k] + 0.5 * e.effort[k] + 0.25 * deviate(dice) + far;
}

/// All terms that the record can have, in a fixed order.
std::vector<Term> terms_of(const Evidence& e) {
  std::vector<Term> all = named_terms(e);
  all.push_back(step_term(e, 1.9));
  all.push_back(periodic_term(e, 2, false));
  all.push_back(periodic_term(e, 1, true));
  all.push_back(free_order_term(e, 6.8));
  all.push_back(position_polynomial_term(e, 3));
  all.push_back(bump_term(e, 0.3, 0.1));
  all.push_back(transition_term(e, 1.2, 0.4));
  return all;
}

std::string name_of(const Term& t) {
  std::string name = t.named() ? t.effect.type : t.unnamed;
  for (const auto& [key, choice] : t.effect.choices) name += ' ' + choice;
  for (const auto& [key, number] : t.effect.numbers)
    if (key == "order") name += ' ' + std::to_string(static_cast<int>(std::lround(number)));
  std::replace(name.begin(), name.end(), ',', ';');
  return name;
}

void expect_fit(const FiguresOfAFit& figure, const std::string& start, const Evidence& e,
                const Explanation& m) {
  figure(start + "log likelihood", m.log_likelihood());
  figure(start + "plain log likelihood", m.plain().log_likelihood);
  figure(start + "noise", m.noise());
  figure(start + "plain noise", m.plain_noise());
  figure(start + "outliers", m.outliers());
  figure(start + "rms of scatter", std::sqrt(m.scatter().square().mean()));
  figure(start + "mean offset", m.mean_offset());
  figure(start + "mean square residual", mean_square_residual(m, e));
  figure(start + "addition", std::sqrt(m.addition().square().mean()));
  figure(start + "inflation", m.variance_inflation(Eigen::ArrayXXd::Ones(e.rows(), 1)));
  const auto found = found_parameters(e, m);
  for (std::size_t i = 0; i < m.terms().size(); ++i) {
    const Term& t = m.terms()[i];
    const std::string name = start + std::to_string(i) + ' ' + name_of(t) + ' ';
    figure(name + "contribution", size_of(m, i));
    figure(name + "coefficients", m.coefficients(i).norm());
    for (const FoundParameter& p : found[i]) {
      figure(name + p.name, p.value);
      figure(name + p.name + " above", p.upper - p.value);
      figure(name + p.name + " below", p.value - p.lower);
    }
  }
}

constexpr Setting settings[]{
    {.name = "nearest"},
    {.name = "free zero", .zero_known = false},
    {.name = "down", .rounding = Rounding::down, .shaft_ratio = -3},
    {.name = "random", .zero_known = false, .random = true},
    {.name = "short", .rows = 130},
    {.name = "few blocks", .rows = 230},
    {.name = "lines", .accelerations = true, .counts_per_period = 1024},
};

TEST(ExplanationFigures, OfFitsWithEveryTermAreAsMeasured) {
  std::uint64_t seed = 0;
  for (const Setting& s : settings) {
    Dice dice(300 + ++seed);
    const Evidence e = recorded(dice, s, mixed);
    const FiguresOfAFit figure(s.name);
    const std::vector<Term> all = terms_of(e);
    Explanation m(e);
    expect_fit(figure, "alone ", e, m);
    // Groups of terms: all effects of a group are fitted together, and every other one is weighed.
    const std::size_t groups = s.rows < 500 ? 3 : 5;
    for (std::size_t g = 0; g < groups; ++g) {
      Explanation grown(e);
      for (std::size_t i = g; i < all.size(); i += groups) grown.add(all[i]);
      grown.fit();
      const std::string start = "group " + std::to_string(g) + ' ';
      expect_fit(figure, start, e, grown);
      for (std::size_t i = 0; i < all.size(); ++i)
        if (i % groups != g)
          figure(start + "gain " + std::to_string(i) + ' ' + name_of(all[i]), grown.gain(all[i]));
      if (g != 1) continue;
      grown.remove(1);
      grown.fit();
      expect_fit(figure, start + "less one ", e, grown);
    }
  }
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
  Addition added;
  double unnamed = 0;  // of uncatalogued terms [counts]
};

std::vector<ScatterRecord> scatter_records() {
  const auto noise = [](double size) {
    return [size](Dice& dice, const Evidence&, Eigen::Index) { return size * deviate(dice); };
  };
  const auto jitter = [](double size) {
    return [size](Dice& dice, const Evidence& e, Eigen::Index k) {
      return size * e.velocity[k] * deviate(dice);
    };
  };
  const auto edges = [](std::vector<double> displaced, double size) {
    return [=](Dice& dice, const Evidence& e, Eigen::Index k) {
      const double position = e.path[k] / e.step() + size * deviate(dice);
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
         const double still = 0.5 * deviate(dice);
         return still + 0.25 * e.velocity[k] * deviate(dice);
       }},
      {"both; more noise",
       [](Dice& dice, const Evidence& e, Eigen::Index k) {
         const double still = 1.2 * deviate(dice);
         return still + 0.2 * e.velocity[k] * deviate(dice);
       }},
      {"alternating edges", edges({0.15, -0.15, 0.15, -0.15}, 0)},
      {"edges", edges({0.2, -0.1, 0.05, -0.15}, 0)},
      {"edges of period four", edges({0.2, 0, -0.2, 0}, 0)},
      {"edges and noise", edges({-0.2, 0.2, -0.2, 0.2}, 0.4)},
      {"small edges", edges({0.03, -0.03, 0.03, -0.03}, 0)},
      {"noise at a place",
       [](Dice& dice, const Evidence& e, Eigen::Index k) {
         const double size = std::abs(e.path[k] - 0.4) < 0.2 ? 3 : 0.3;
         return size * deviate(dice);
       }},
      {"noise for a while",
       [](Dice& dice, const Evidence& e, Eigen::Index k) {
         const double size = std::abs(e.time[k] - 1.5) < 0.2 ? 4 : 0.2;
         return size * deviate(dice);
       }},
      {"uneven noise",
       [](Dice& dice, const Evidence& e, Eigen::Index k) {
         const double size = 1 + 0.4 * std::sin(e.path[k]);
         return size * deviate(dice);
       }},
      {"a wave", [](Dice&, const Evidence& e, Eigen::Index k) { return 3 * std::sin(1.3 * e.time[k]); }},
      {"a wave for a while",
       [](Dice&, const Evidence& e, Eigen::Index k) {
         return e.time[k] < 0.4 ? 6 * std::sin(15 * e.time[k]) : 0;
       }},
      {"a bump", [](Dice&, const Evidence& e,
                    Eigen::Index k) { return 5 * std::exp(-std::pow((e.path[k] - 0.4) / 0.2, 2)); }},
      {"single readings", [](Dice& dice, const Evidence&,
                             Eigen::Index k) { return k == 310 || k == 700 ? 40 : 0.1 * deviate(dice); }},
      {"heavy tails",
       [](Dice& dice, const Evidence&, Eigen::Index) {
         const double size = dice.chance(0.04) ? 5 : 0.3;
         return size * deviate(dice);
       }},
  };
}

constexpr Setting scatter_settings[]{
    {.name = "nearest", .rows = 1300},
    {.name = "of poses", .rounding = Rounding::down, .ordered = false, .rows = 1300},
    {.name = "random", .zero_known = false, .random = true, .rows = 1100},
    {.name = "short", .rows = 470},
};

void expect_scatter(const FiguresOfAFit& figure, const Evidence& e, const Explanation& m, double unnamed) {
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
    const Intervals moved = displaced(m.intervals(), e, s.pattern);
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

TEST(ExplanationFigures, OfScatterAndRemaindersAreAsMeasured) {
  for (const Setting& s : scatter_settings) {
    std::uint64_t seed = 500;
    for (const ScatterRecord& r : scatter_records()) {
      Dice dice(++seed);
      const Evidence e = recorded(dice, s, r.added);
      const Explanation m(e);
      const FiguresOfAFit figure(std::string(s.name) + "; " + r.name);
      expect_scatter(figure, e, m, r.unnamed * e.step());
    }
  }
}

TEST(ExplanationFigures, OfARecordAtRestAreAsMeasured) {
  for (const double size : {0.0, 0.4, 1.5}) {
    Dice dice(77);
    Evidence e = recorded(dice, {.name = "", .rows = 700},
                          [&](Dice& d, const Evidence&, Eigen::Index) { return size * deviate(d); });
    const Eigen::ArrayXd errors = e.measured - e.path;
    e.path.setConstant(0.37 * e.step());
    e.velocity.setZero();
    e.direction.setZero();
    for (Eigen::Index k = 0; k < e.rows(); ++k) e.measured[k] = quantize(e.encoder, e.path[k] + errors[k]);
    const FiguresOfAFit figure("rest " + std::to_string(static_cast<int>(10 * size)));
    expect_scatter(figure, e, Explanation(e), 0);
  }
}

}  // namespace
}  // namespace qerr
