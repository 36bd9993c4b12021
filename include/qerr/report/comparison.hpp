#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace qerr {

struct SpecCheck;  // analysis.hpp

/// A figure of a report under the name that requirements give it.
struct NamedFigure {
  std::string quantity;           ///< `position.x.worst_case`, `velocity.delay`
  std::string statistic;          ///< `max`; "" for a figure of a filter
  std::string unit;               ///< SI, "" for a pure number
  double value = 0;               ///< +inf: unbounded
  bool larger_is_better = false;  ///< a margin, a bandwidth, a stiffness

  /// `position.x.worst_case max`.
  std::string name() const { return statistic.empty() ? quantity : quantity + ' ' + statistic; }
};

/// A requirement, and how a report judges it.
struct JudgedRequirement {
  NamedFigure figure;
  bool at_least = false;  ///< the limit is the lowest value; else the highest
  double limit = 0;
  bool met = false;
};

/// An encoder's share of the variance of the tip.
struct EncoderShare {
  std::string encoder;
  double share = 0;
};

/// A report as a list of named figures: the one form in which reports are compared.
///
/// Figures that the report does not know, such as sigma behind a filter with an effect that depends on the
/// motion, are not in the list.
struct NamedFigures {
  std::string file;     ///< of the report, or of the spec
  std::string spec;     ///< its file, "" in a report of filters
  std::string command;  ///< that wrote the report; "spec" if it was computed now
  /// `encoders.a2.bits=19`: the values of the spec that --set replaced.
  std::vector<std::string> changes;
  std::string robot;   ///< `arm, base -> tool0`; "" in a report of filters
  std::string sha256;  ///< of the spec; "" in an older report
  std::string sample;  ///< `sobol, 10000 configurations, seed 1`; "" in a report of filters
  std::vector<NamedFigure> figures;
  std::vector<EncoderShare> shares;
  std::vector<JudgedRequirement> requirements;
};

/// The figures of a report of analyze, check or filter.
/// @param text  in JSON
/// @throws Error (input) if it is no such report
NamedFigures read_named_figures(const std::string& text, const std::string& file);

/// Of each spec of a report of several; else of one.
std::vector<NamedFigures> read_all_named_figures(const std::string& text, const std::string& file);

/// A figure in one report and in another one.
struct FigureChange {
  NamedFigure figure;          ///< its value is that of B, or of A where B has none
  std::optional<double> a, b;  ///< empty: the report has no such figure
  /// (b - a)/|a|: infinite from zero and to what is unbounded, 0 if both are equal but for rounding. NaN if
  /// one is missing.
  double relative = 0;

  bool in_both() const { return a && b; }
};

/// An earlier report, and how much worse than in it a figure may be.
struct Baseline {
  NamedFigures figures;
  double tolerance = 0;  ///< relative
};

/// The baselines of one or several specs.
using Baselines = std::vector<Baseline>;

/// A spec's figures beside those of a baseline.
struct BaselineCheck {
  std::string file;  ///< of the baseline
  double tolerance = 0;
  std::size_t compared = 0;                             ///< figures that both have
  std::vector<FigureChange> regressions;                ///< A is the baseline; the worst first
  std::vector<NamedFigure> missing;                     ///< figures that the spec does not have
  std::vector<JudgedRequirement> dropped_requirements;  ///< that the spec does not have
  std::vector<NamedFigure> not_in_baseline;             ///< required by the spec
  std::vector<std::string> warnings;

  /// One regression of each quantity: that of its maximum, else the worst one. The worst ones first.
  std::vector<FigureChange> worst_by_quantity() const;
};

/// The figures of a spec: those that a report of `command` has, or with "spec" all of them.
NamedFigures named_figures(const SpecCheck&, const std::string& command = "spec");

struct ShareChange {
  std::string encoder;
  std::optional<double> a, b;
};

struct RequirementChange {
  std::optional<JudgedRequirement> a, b;  ///< at least one

  const JudgedRequirement& any() const { return b ? *b : *a; }
  bool flipped() const { return a && b && a->met != b->met; }
  /// Of a flipped requirement: the part of the way from A to B after which its value passes the limit, if the
  /// value changes evenly.
  std::optional<double> flips_after() const;
};

/// How far a value is from its limit, relative to it: negative if the requirement is not met. NaN for a limit
/// of 0.
double margin(const JudgedRequirement&);

/// The result of `qerr compare`.
struct ReportComparison {
  NamedFigures a, b;
  bool details = false;               ///< its table shows every figure
  std::vector<FigureChange> figures;  ///< the largest relative changes first, then those of one report
  std::vector<ShareChange> shares;    ///< the largest differences first
  std::vector<RequirementChange> requirements;  ///< flipped ones in the order in which they
                                                ///< flip, then those with the smallest margin in B
  std::vector<std::string> warnings;            ///< of what makes figures hard to compare
};

/// @throws Error (input) if the reports are of different commands, or a figure has two units
ReportComparison compare(NamedFigures a, NamedFigures b);

}  // namespace qerr
