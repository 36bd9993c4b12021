#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "qerr/bound/figure.hpp"
#include "qerr/report/write.hpp"
#include "report/sweep/run_sweep.hpp"
#include "report/text_table.hpp"

namespace qerr {

/// How a sweep is written as CSV: a header, and the lines of each variant, which depend on nothing else.
struct SweepRows {
  std::string header;  ///< without the end of the line
  /// Lines, each with its "\r\n".
  std::function<std::string(const SweptVariant&)> lines;
};

/// One row a figure: the variant, its keys, and the columns of an analysis in CSV. A variant that cannot be
/// computed has one row with the signal `error` and the fault in the column `bound`.
/// @param grid  must outlive the rows, as in all functions below
SweepRows tidy_rows(const SweepGrid& grid, std::vector<const StatisticKind*> statistics);

/// One row a variant: its keys, every figure, the norms and other figures of its filters, its requirements
/// with their verdict, and its fault.
///
/// The columns are those of the first variant that can be read, and of the variants that differ from it in
/// one step. @throws Error (input; key `sweep`) from `lines` for a variant with further columns
SweepRows wide_rows(const SweepGrid& grid, const SpecVariants&, std::vector<const StatisticKind*> statistics);

/// A sweep as JSON: the texts before, between and after those of its variants.
struct SweepJson {
  std::string begin, separator, end;
  static std::string variant(const SweptVariant&, const SweepGrid&, const std::vector<const StatisticKind*>&);
};
SweepJson sweep_json(const SpecVariants&, const SweepGrid&);

/// A dotted path in words that a narrow column can break.
std::string in_words(std::string path);

/// A sweep as a table: one line a variant, with the requirements' values, or else the largest worst case of
/// every coordinate and the largest sigma behind every filter.
class SweepTable {
 public:
  SweepTable(const SpecVariants&, const SweepGrid&);

  /// The cells of a variant, to be given to `add` in order; called on any thread.
  std::vector<std::string> row(const SweptVariant&) const;
  void add(std::vector<std::string> row) { cells_.push_back(std::move(row)); }
  std::string text(const Style&) const;

 private:
  std::vector<std::string> figures(const SpecCheck&) const;

  const SpecVariants& variants_;
  const SweepGrid& grid_;
  TableRows cells_;
};

/// The key of a sweep whose values are numbers of one dimension: what figures are drawn over.
struct SweepAbscissa {
  std::size_t axis = 0;
  std::string key, unit;
  std::vector<double> values;      ///< of the axis' steps [SI]
  std::vector<std::size_t> order;  ///< steps by ascending value
  bool logarithmic = false;        ///< equally spaced in the logarithm
};

/// Which variants of a sweep a page draws: it depends on the grid alone, so that the same ones are drawn
/// whatever the threads.
struct DrawnVariants {
  /// The variants of one combination of the other keys, by ascending value of the abscissa.
  struct Line {
    std::string name;
    std::vector<std::uint64_t> variants;
  };

  std::optional<SweepAbscissa> abscissa;  ///< empty: one bar a variant, in a single line
  std::vector<Line> lines;
  std::uint64_t lines_in_all = 1;  ///< combinations of the other keys
  std::size_t points_in_all = 0;   ///< of a line

  double value(const SweepGrid&, std::uint64_t variant) const;
};

/// A sweep as a page: its requirements' values, the largest worst case of every coordinate and the largest
/// sigma behind every filter, over each key that has numbers, one line for each combination of the others.
///
/// What is kept does not grow with the number of variants beyond what is drawn.
class SweepPage {
 public:
  SweepPage(const SpecVariants&, const SweepGrid&);

  /// The figures of a variant, NaN where it has none.
  struct VariantFigures {
    char verdict = '-';         ///< of its requirements: y met, n not, - not judged
    bool other_limits = false;  ///< its requirements are not those of the spec
    std::vector<double> values = {};
  };

  /// The figures of a variant, to be given to `add` in order; called on any thread.
  VariantFigures row(const SweptVariant&) const;
  void add(const VariantFigures&);
  std::string text(const SweepOutcome&) const;

 private:
  struct SweptQuantity {
    std::string name, unit;
    std::ptrdiff_t requirement = -1;  ///< of the spec; -1: a figure by its name
  };
  struct Extreme {
    double value = 0;
    std::uint64_t variant = 0;
  };

  void add_figures();
  std::optional<double> tightest(const VariantFigures&) const;
  const Requirement* required(const SweptQuantity&) const;
  double value(std::size_t figure, std::uint64_t variant) const;
  std::string answer() const;
  std::string picture(std::size_t figure, const DrawnVariants&) const;
  std::string plot(std::size_t figure, const DrawnVariants&) const;
  std::string matrix(std::size_t figure, const DrawnVariants&) const;
  std::string bars(std::size_t figure, const DrawnVariants&) const;
  std::string what_is_drawn(const DrawnVariants&) const;
  std::string table() const;

  const SpecVariants& variants_;
  const SweepGrid& grid_;
  std::vector<SweptQuantity> figures_;
  std::vector<DrawnVariants> drawn_;
  std::map<std::uint64_t, VariantFigures>
      kept_;                ///< rows that are drawn or in the table; empty until they are added
  std::uint64_t next_ = 0;  ///< number of the variant that is added next
  std::uint64_t met_ = 0, judged_ = 0;
  std::vector<std::optional<Extreme>> least_, largest_;  ///< of every figure
  std::optional<Extreme> best_;                          ///< that uses the least part of its tightest limit
  bool limits_vary_ = false;                             ///< the sweep changes a requirement
};

}  // namespace qerr
