#pragma once

#include "qerr/report/comparison.hpp"

namespace qerr {

/// (b - a)/|a|; 0 if both agree to 1e-9, infinite from zero and to what is unbounded, -1 from unbounded.
double relative_change(double a, double b);

/// The figure of the same name; null if there is none.
const NamedFigure* find_figure(const NamedFigures&, const NamedFigure& like);

/// The largest relative changes first, those of one report only at the end.
/// @throws Error (input) if a figure has two units
std::vector<FigureChange> figure_changes(const NamedFigures& a, const NamedFigures& b);

/// What makes the figures of two reports hard to compare.
std::vector<std::string> comparison_warnings(const NamedFigures& a, const NamedFigures& b);

/// The figures of a spec beside those of a baseline.
BaselineCheck against(const Baseline&, const NamedFigures& now);

/// `+12.3 %`, `unchanged`, `from zero`, `now unbounded`, `now bounded`.
std::string change_text(const FigureChange&);

/// The figures of both reports that are worth a reader's time: those that read differently, and without
/// `details` only the maximum of a quantity in place of its other statistics.
std::vector<FigureChange> notable_figures(const ReportComparison&);

/// Figures that only A, or only B, has: their names, or their quantities.
std::vector<std::string> names_in_one(const ReportComparison&, bool in_a, bool quantities);

/// What has flipped, and how many figures grew and shrank.
std::string comparison_sentence(const ReportComparison&);

/// `1.2 mm <= 1.5 mm`; `no such requirement`.
std::string judged_text(const std::optional<JudgedRequirement>&);

/// `NOT MET any more`: which way a verdict flipped.
std::string flip_text(const RequirementChange&);

/// The requirement that is met in both and has the smallest margin in B; null: none.
const RequirementChange* next_to_flip(const ReportComparison&);

/// Whether a figure speaks for its quantity in a table: the maximum, and a figure of a filter.
inline bool is_main(const NamedFigure& f) { return f.statistic.empty() || f.statistic == "max"; }

/// Whether both limit the same figure from the same side.
bool same_limit(const JudgedRequirement& a, const JudgedRequirement& b);

}  // namespace qerr
