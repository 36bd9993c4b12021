#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "diagnose/inference/explanation.hpp"
#include "diagnose/inference/finding.hpp"
#include "diagnose/inference/found_parameters.hpp"
#include "diagnose/search/unnamed_terms.hpp"
#include "support/fit_record.hpp"
#include "support/record_figures.hpp"

/// Every figure of fits and intervals of small synthetic records, in which the path is known and no search
/// chooses the terms.
namespace qerr {
namespace {

using testing::Dice;
using testing::FitSetting;
using testing::normal_deviate;
using testing::record_of_fit;
using testing::RecordFigures;

/// 1e-6 of each: the last step of a fit may differ between compilers.
const testing::Measured& figures_of_fits() {
  static const testing::Measured all("explanation_figures.csv", 1e-6);
  return all;
}

/// A sum of several effects and noise: nothing is exactly zero.
double every_effect(Dice& dice, const Evidence& e, Eigen::Index k) {
  const double q = e.path[k], t = e.time[k], v = e.velocity[k];
  const double slow = 0.3 + 1.4 * q + 0.9 * std::sin(2 * q + 0.5) + 0.6 * std::sin(7 * q - 1) + 0.8 * v;
  const double lost = t > 1.9 ? -2 : 0, warm = 1.1 * (1 - std::exp(-t / 0.9));
  const double far = dice.chance(0.01) ? 9 : 0;
  return slow + lost + warm + 0.4 * e.direction[k] + 0.5 * e.effort[k] + 0.25 * normal_deviate(dice) + far;
}

/// All terms that the record can have, in a fixed order.
std::vector<Term> every_term(const Evidence& e) {
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

std::string name_of_term(const Term& t) {
  std::string name = t.named() ? t.effect.type : t.unnamed;
  for (const auto& [key, choice] : t.effect.choices) name += ' ' + choice;
  for (const auto& [key, number] : t.effect.numbers)
    if (key == "order") name += ' ' + std::to_string(static_cast<int>(std::lround(number)));
  std::replace(name.begin(), name.end(), ',', ';');
  return name;
}

void expect_fit(const RecordFigures& figure, const std::string& start, const Evidence& e,
                const Explanation& m) {
  figure(start + "log likelihood", m.log_likelihood());
  figure(start + "noise", m.noise());
  figure(start + "outliers", m.outliers());
  figure(start + "rms of scatter", std::sqrt(m.scatter().square().mean()));
  figure(start + "mean offset", m.mean_offset());
  figure(start + "mean square residual", mean_square_residual(m, e));
  figure(start + "addition", std::sqrt(m.addition().square().mean()));
  figure(start + "inflation", m.variance_inflation(Eigen::ArrayXXd::Ones(e.rows(), 1)));
  const auto found = found_parameters(e, m);
  for (std::size_t i = 0; i < m.terms().size(); ++i) {
    const Term& t = m.terms()[i];
    const std::string name = start + std::to_string(i) + ' ' + name_of_term(t) + ' ';
    figure(name + "contribution", size_of(m, i));
    figure(name + "coefficients", m.coefficients(i).norm());
    for (const FoundParameter& p : found[i]) {
      figure(name + p.name, p.value);
      figure(name + p.name + " above", p.upper - p.value);
      figure(name + p.name + " below", p.value - p.lower);
    }
  }
}

constexpr FitSetting fit_settings[]{
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
  for (const FitSetting& s : fit_settings) {
    Dice dice(300 + ++seed);
    const Evidence e = record_of_fit(dice, s, every_effect);
    const RecordFigures figure(figures_of_fits(), s.name);
    const std::vector<Term> all = every_term(e);
    Explanation m(e);
    expect_fit(figure, "alone ", e, m);
    // Groups of terms: those of a group are fitted together. Many in a short record would determine each
    // other to rounding errors only.
    const std::size_t groups = s.rows < 500 ? 14 : 9;
    for (std::size_t g = 0; g < groups; ++g) {
      Explanation grown(e);
      for (std::size_t i = g; i < all.size(); i += groups) grown.add(all[i]);
      grown.fit();
      const std::string start = "group " + std::to_string(g) + ' ';
      expect_fit(figure, start, e, grown);
      if (g % 4 != 1) continue;
      grown.remove(grown.terms().size() / 2);
      grown.fit();
      expect_fit(figure, start + "less one ", e, grown);
    }
  }
}

}  // namespace
}  // namespace qerr
