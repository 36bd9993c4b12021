#pragma once

#include "qerr/report/comparison.hpp"

namespace qerr {

/// (b - a)/|a|; 0 if both agree to 1e-9, infinite from zero and to what is unbounded, -1 from unbounded.
double relative_change(double a, double b);

/// Whether both are the same statistic of the same quantity.
inline bool same_figure(const NamedFigure& a, const NamedFigure& b) {
  return a.quantity == b.quantity && a.statistic == b.statistic;
}
/// Finds a figure in another report; null if it has none like it.
const NamedFigure* find_figure(const NamedFigures&, const NamedFigure& like);

/// The figures of a spec beside those of a baseline.
BaselineCheck against(const Baseline&, const NamedFigures& now);

/// `+12.3 %`, `unchanged`, `from zero`, `now unbounded`, `now bounded`.
std::string change_text(const FigureChange&);

/// Whether a figure speaks for its quantity in a table: the maximum, and a figure of a filter.
inline bool is_main(const NamedFigure& f) { return f.statistic.empty() || f.statistic == "max"; }

/// `3 of 120 figures worse than in old.json by more than 2 %`, or `none of ...`.
std::string verdict(const BaselineCheck&);

/// `velocity.x.sigma max was 1.00 mm/s and is 1.20 mm/s (+20 %)`.
std::string verdict(const FigureChange& regression);

/// Quantities that a person is told of; the others are counted.
inline constexpr std::size_t most_regressions = 10;

}  // namespace qerr
