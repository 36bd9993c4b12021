#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "core/text.hpp"
#include "diagnose/record/sanity/sanity_steps.hpp"

/// Columns that are in another unit than their header says, or that belong to another joint.
namespace qerr::sanity {

namespace {

struct UsualUnit {
  double in_si;
  std::string_view name;
};

constexpr double degree = std::numbers::pi / 180;

/// Units in which positions are written.
constexpr std::array<UsualUnit, 6> angles{{{1, "rad"},
                                           {degree, "deg"},
                                           {degree / 60, "arcmin"},
                                           {degree / 3600, "arcsec"},
                                           {1e-3, "mrad"},
                                           {2 * std::numbers::pi, "rev"}}};
constexpr std::array<UsualUnit, 5> lengths{
    {{1, "m"}, {1e-3, "mm"}, {1e-6, "um"}, {1e-2, "cm"}, {0.0254, "inch"}}};

/// Units in which velocities are written.
constexpr std::array<UsualUnit, 5> rotations{{{1, "rad/s"},
                                              {degree, "deg/s"},
                                              {std::numbers::pi / 30, "rpm"},
                                              {2 * std::numbers::pi, "rev/s"},
                                              {1e-3, "mrad/s"}}};
constexpr std::array<UsualUnit, 3> translations{{{1, "m/s"}, {1e-3, "mm/s"}, {1e-3 / 60, "mm/min"}}};

/// Ratios of wrongly decoded counts, which a wrong unit may come with.
constexpr std::array<double, 5> decodings{1, 0.5, 2, 0.25, 4};

/// A column in another unit correlates with the other one by more than this, whatever the encoder's errors
/// are.
constexpr double proportional = 0.98;

/// The factors differ by 4 % and more, so that each slope has one factor at most.
constexpr double same_factor = 0.02;

/// The measured position of a joint and its reference; empty arrays if one is missing or rests.
struct Pair {
  Eigen::ArrayXd measured, reference;
  bool moves = false;
};

Pair pair_of(const Sanity& s, std::size_t joint) {
  Pair p;
  const auto column = s.log.find(LogSignal::reference, joint);
  const auto measured = measured_joint(s.log, s.log.values, s.model.transmission, joint);
  if (!column || !measured || s.log.values.rows() < fewest_rows_of_slope) return p;
  p.measured = some_rows(*measured);
  p.reference = some_rows(s.log.values.col(*column));
  // Eight counts: less has no slope.
  p.moves =
      peak_to_peak(p.measured) > 8 * ideal_sigma(s, joint) * std::sqrt(12.0) && peak_to_peak(p.reference) > 0;
  return p;
}

}  // namespace

std::optional<OtherUnit> other_unit(const LogColumn& column, double ratio, bool prismatic) {
  const bool velocity = column.signal == LogSignal::velocity;
  const std::span<const UsualUnit> units = velocity    ? (prismatic ? std::span<const UsualUnit>(translations)
                                                                    : std::span<const UsualUnit>(rotations))
                                           : prismatic ? std::span<const UsualUnit>(lengths)
                                                       : std::span<const UsualUnit>(angles);
  const double header = column.scale.in_si(1);
  for (const double decoding : decodings)
    for (const UsualUnit& unit : units)
      if (const double factor = header / unit.in_si; std::abs(factor - 1) > 2 * same_factor)
        // With wrong decoding only degrees, the usual mistake: else a wrong gear ratio could look like it.
        if (decoding == 1 || (!velocity && unit.in_si == degree))
          if (std::abs(ratio / (factor * decoding) - 1) < same_factor) return OtherUnit{unit.name, factor};
  return std::nullopt;
}

namespace {

/// Whole turns that were added to bring a column near readings in another unit, or of another joint, were
/// none.
void take_turns_back(Sanity& s, std::size_t joint, Eigen::Index column) {
  if (s.model.chain.independent[joint].prismatic()) return;
  Wraps& wraps = s.log.columns[static_cast<std::size_t>(column)].wraps;
  s.log.values.col(column) -= 2 * std::numbers::pi * static_cast<double>(std::exchange(wraps.start, 0));
}

/// Converts a column whose values are in another unit than its header says, and reports it.
void convert(Sanity& s, std::size_t joint, Eigen::Index column, const OtherUnit& unit) {
  const LogColumn& c = s.log.columns[static_cast<std::size_t>(column)];
  s.data.push_back({c.header + " looks like " + std::string(unit.name) + ": its values are " +
                        significant(unit.factor, 4) + " times what the header says",
                    s.model.chain.independent[joint].name,
                    1,
                    {},
                    "write [" + std::string(unit.name) + "] in the header, or convert the column",
                    DataKind::contradictory});
  s.spoilt = s.data.back().what + ": " + s.data.back().remedy;
  take_turns_back(s, joint, column);
  s.log.values.col(column) /= unit.factor;
}

}  // namespace

void check_unit(Sanity& s, std::size_t joint) {
  const Pair p = pair_of(s, joint);
  if (!p.moves || std::abs(correlation(p.measured, p.reference)) < proportional) return;
  const double slope = std::abs(fit_line(p.reference, p.measured).slope);
  const bool prismatic = s.model.chain.independent[joint].prismatic();
  const auto wrong = [&](Eigen::Index column, double ratio) {
    const auto unit = other_unit(s.log.columns[static_cast<std::size_t>(column)], ratio, prismatic);
    if (unit) convert(s, joint, column, *unit);
    return unit.has_value();
  };
  if (wrong(*s.log.find(LogSignal::reference, joint), 1 / slope)) return;
  if (const auto measured = s.log.find(LogSignal::measured, joint); measured) wrong(*measured, slope);
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
          std::abs(correlation(a.measured, b.reference)) < crossed ||
          std::abs(correlation(b.measured, a.reference)) < crossed)
        continue;
      // Counts of another encoder have its resolution and its sign.
      constexpr double other_ratio = 0.1;
      const bool counts = s.log.find(LogSignal::counts, i) && s.log.find(LogSignal::counts, j) &&
                          std::abs(fit_line(b.reference, a.measured).slope - 1) > other_ratio;
      const LogSignal signal = counts ? LogSignal::counts : LogSignal::reference;
      const std::string one = s.model.chain.independent[i].name, other = s.model.chain.independent[j].name;
      s.data.push_back(
          {"the columns of " + one + " and " + other +
               " look exchanged: the readings of each follow the reference of the other",
           one,
           1,
           {},
           "exchange the headers of the counts, or of the references, of " + one + " and " + other,
           DataKind::contradictory});
      s.spoilt = s.data.back().what + ": " + s.data.back().remedy;
      for (const std::size_t joint : {i, j})
        if (counts) take_turns_back(s, joint, *s.log.find(LogSignal::reference, joint));
      s.log.values.col(*s.log.find(signal, i)).swap(s.log.values.col(*s.log.find(signal, j)));
      const auto& encoders = s.model.transmission.encoders;
      for (const std::size_t joint : {i, j}) {
        if (counts)
          s.log.values.col(*s.log.find(signal, joint)) *= direction(encoders[i]) * direction(encoders[j]);
        pairs[joint] = pair_of(s, joint);
      }
    }
}

}  // namespace qerr::sanity
