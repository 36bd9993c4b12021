#include "diagnose/search/contrast_test.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/probability.hpp"
#include "core/statistics.hpp"
#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

constexpr double refuted = 0.001;

/// Part of what a name explains beside all chosen terms that it must explain beside the names alone.
constexpr double least_part_alone = 0.25;

/// Part of an uncatalogued shape that it leaves, where its form is guessed.
constexpr double guess_error = 0.2;

/// Whether an order is no more than those beside it, at distances that the range resolves.
bool is_among_neighbours(const ErrorModel& m, const Choice& c, std::size_t i) {
  const Term& t = m.term(c.chosen[i]);
  if (!t.named() || !t.harmonic) return false;
  const double order = std::abs(wave_number(t.effect, m.sampled().encoder));
  const double resolution = 2 * std::numbers::pi / m.sampled().range();
  if (order < resolution) return false;  // of less than a period there is no neighbour
  const Eigen::ArrayXd residual = c.residual + addition(t, m.coefficients(c.chosen, c.fit, i));
  double sum = 0;
  int count = 0;
  for (int k = 0; k < 8; ++k)
    for (const double other : {order - (1.5 + k) * resolution, order + (1.5 + k) * resolution}) {
      if (other < 0.75 * resolution) continue;
      sum += m.gain(free_order_term(m.sampled(), other), residual);
      ++count;
    }
  const double ratio = m.gain(t, residual) / std::max(sum / count, 1e-300);
  return fisher_f_tail(ratio, 2, 2.0 * count) > refuted;
}

/// Whether a name explains little beside the other names, although much beside all terms.
bool corrects_shapes(const ErrorModel& m, const Choice& c, std::size_t i) {
  if (!m.term(c.chosen[i]).named()) return false;
  LinearModel::Set names, others;
  for (const std::size_t g : c.chosen) {
    if (!m.term(g).named()) continue;
    names.push_back(g);
    if (g != c.chosen[i]) others.push_back(g);
  }
  if (names.size() == c.chosen.size()) return false;
  return m.fit(others).rss - m.fit(names).rss < least_part_alone * m.lost_without(c, i);
}

/// Whether the form of an uncatalogued shape is one of many that it could have, unlike that of a step or a
/// line.
bool is_guessed(Shape s) { return s == Shape::hysteresis || s == Shape::exponential || s == Shape::bump; }

/// Whether a name is smaller than what the largest guessed shape may leave.
bool is_detail_of_guess(const ErrorModel& m, const Choice& c, std::size_t i) {
  if (!m.term(c.chosen[i]).named() || m.term(c.chosen[i]).constant) return false;
  const auto size = [&](std::size_t k) {
    return standard_deviation(addition(m.term(c.chosen[k]), m.coefficients(c.chosen, c.fit, k)));
  };
  double largest = 0;
  for (std::size_t k = 0; k < c.chosen.size(); ++k)
    if (!m.term(c.chosen[k]).named() && is_guessed(m.term(c.chosen[k]).pattern))
      largest = std::max(largest, size(k));
  return size(i) < guess_error * largest;
}

/// Whether an order of which less than half a period is seen may be, with another curve beside it, a part of
/// one curve: the other is uncatalogued, or less than a period of it is seen.
bool is_part_of_curve(const ErrorModel& m, const Choice& c, std::size_t i) {
  return m.is_arc(c.chosen[i]) && std::any_of(c.chosen.begin(), c.chosen.end(), [&](std::size_t g) {
           return g != c.chosen[i] && (!m.term(g).named() || m.periods(g) < 1);
         });
}

}  // namespace

std::vector<std::string> without_contrast(const ErrorModel& m, const Choice& c) {
  std::vector<std::string> families;
  for (std::size_t i = 0; i < c.chosen.size(); ++i)
    if (is_among_neighbours(m, c, i) || corrects_shapes(m, c, i) || is_detail_of_guess(m, c, i) ||
        is_part_of_curve(m, c, i))
      families.push_back(m.candidate(c.chosen[i]).family);
  return families;
}

}  // namespace qerr
