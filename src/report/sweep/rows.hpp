#pragma once

#include <functional>
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

/// The number of a variant and the values of its keys, numbers in SI units: the cells at the begin of its
/// lines, with their commas; and the header of these cells.
std::string cells_of_variant(const SweepGrid&, std::uint64_t variant);
std::string header_of_variants(const SweepGrid&);

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

}  // namespace qerr
