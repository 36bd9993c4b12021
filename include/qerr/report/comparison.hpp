#pragma once

#include <optional>
#include <string>
#include <vector>

#include "qerr/report/analysis.hpp"
#include "qerr/report/named_figures.hpp"

namespace qerr {

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
