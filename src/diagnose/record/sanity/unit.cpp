#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"

/// Columns that are in another unit than their header says, or that belong to another joint.
namespace qerr::sanity {

namespace {

struct UnitFactor {
  double factor;  ///< number in the column per number in the unit of its header
  std::string_view unit;
};

constexpr double degrees = 180 / std::numbers::pi;

/// Units in which angles and lengths are written [per rad or per m].
constexpr std::array<UnitFactor, 5> angles{{{degrees, "deg"},
                                            {60 * degrees, "arcmin"},
                                            {3600 * degrees, "arcsec"},
                                            {1000, "mrad"},
                                            {0.5 / std::numbers::pi, "turns"}}};
constexpr std::array<UnitFactor, 3> lengths{{{1000, "mm"}, {1e6, "um"}, {1000 / 25.4, "inch"}}};

/// A column in another unit correlates with the other one by more than this, whatever the encoder's errors
/// are.
constexpr double proportional = 0.98;

/// The factors lie more than 2 % apart from each other and from 1; a wrong gear ratio of a few percent beside
/// a wrong unit is not looked for.
constexpr double same_factor = 0.02;

constexpr Eigen::Index fewest_rows = 16, most_rows = 8192;

/// At most `most_rows` rows, evenly spaced.
Eigen::ArrayXd thinned(const Eigen::ArrayXd& x) {
  const Eigen::Index n = std::min(x.size(), most_rows);
  Eigen::ArrayXd out(n);
  for (Eigen::Index k = 0; k < n; ++k) out[k] = x[k * x.size() / n];
  return out;
}

double correlation(const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
  const double deviation = standard_deviation(x) * standard_deviation(y);
  return deviation > 0 ? ((x - x.mean()) * (y - y.mean())).mean() / deviation : 0;
}

/// The measured position of a joint and its reference; empty arrays if one is missing or rests.
struct Pair {
  Eigen::ArrayXd measured, reference;
  bool moves = false;
};

Pair pair_of(const Sanity& s, std::size_t joint) {
  Pair p;
  const auto column = s.log.find(LogSignal::reference, joint);
  const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, joint);
  if (!column || !measured || s.log.values.rows() < fewest_rows) return p;
  p.measured = thinned(*measured);
  p.reference = thinned(s.log.values.col(*column));
  // Eight counts: less has no slope.
  p.moves =
      peak_to_peak(p.measured) > 8 * ideal_sigma(s, joint) * std::sqrt(12.0) && peak_to_peak(p.reference) > 0;
  return p;
}

}  // namespace

void check_unit(Sanity& s, std::size_t joint) {
  const Pair p = pair_of(s, joint);
  if (!p.moves || std::abs(correlation(p.measured, p.reference)) < proportional) return;
  const double slope = std::abs(fit_line(p.reference, p.measured).slope);
  const bool prismatic = s.model.chain.independent[joint].prismatic();
  const auto check = [&](const UnitFactor& u) {
    // The reference is `factor` times too large, or the positions are.
    const bool reference = std::abs(slope * u.factor - 1) < same_factor;
    const auto measured = s.log.find(LogSignal::measured, joint);
    if (!reference && !(measured && std::abs(slope / u.factor - 1) < same_factor)) return false;
    const Eigen::Index column = reference ? *s.log.find(LogSignal::reference, joint) : *measured;
    const LogColumn& c = s.log.columns[static_cast<std::size_t>(column)];
    s.data.push_back({c.header + " looks like " + std::string(u.unit) + ": it is " +
                          significant(u.factor, 4) + " times what its header says",
                      s.model.chain.independent[joint].name,
                      1,
                      {},
                      "write [" + std::string(u.unit) + "] into the header, or convert the column"});
    s.spoilt = s.data.back().what + ": " + s.data.back().remedy;
    // Whole turns that were added to bring the reference near the readings were none.
    if (!prismatic) s.log.values.col(column) -= 2 * std::numbers::pi * static_cast<double>(c.wraps.start);
    s.log.values.col(column) /= u.factor;
    return true;
  };
  if (prismatic) {
    for (const UnitFactor& u : lengths)
      if (check(u)) return;
  } else {
    for (const UnitFactor& u : angles)
      if (check(u)) return;
  }
}

void check_exchange(Sanity& s) {
  constexpr double own = 0.95, crossed = 0.999;
  const std::size_t joints = s.model.chain.independent.size();
  std::vector<Pair> pairs;
  for (std::size_t j = 0; j < joints; ++j) pairs.push_back(pair_of(s, j));
  for (std::size_t i = 0; i < joints; ++i)
    for (std::size_t j = i + 1; j < joints; ++j) {
      const Pair &a = pairs[i], &b = pairs[j];
      if (!a.moves || !b.moves || std::abs(correlation(a.measured, a.reference)) > own ||
          std::abs(correlation(b.measured, b.reference)) > own ||
          correlation(a.measured, b.reference) < crossed || correlation(b.measured, a.reference) < crossed)
        continue;
      const Eigen::Index first = *s.log.find(LogSignal::reference, i),
                         second = *s.log.find(LogSignal::reference, j);
      const std::string one = s.model.chain.independent[i].name, other = s.model.chain.independent[j].name;
      s.data.push_back(
          {"the columns of " + one + " and " + other +
               " look exchanged: the readings of each follow the reference of the other",
           one,
           1,
           {},
           "exchange the headers of the counts, or of the references, of " + one + " and " + other});
      s.spoilt = s.data.back().what + ": " + s.data.back().remedy;
      s.log.values.col(first).swap(s.log.values.col(second));
      std::swap(pairs[i].reference, pairs[j].reference);
    }
}

}  // namespace qerr::sanity
