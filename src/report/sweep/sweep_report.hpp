#pragma once

#include <string>
#include <vector>

#include "qerr/report/write.hpp"
#include "report/sweep/run_sweep.hpp"

namespace qerr {

/// A sweep as JSON: the texts before, between and after those of its variants.
struct SweepJson {
  std::string begin, separator, end;
  static std::string variant(const SweptVariant&, const SweepGrid&, const std::vector<const StatisticKind*>&);
};
SweepJson sweep_json(const SpecVariants&, const SweepGrid&);

/// A sweep as a table: one line a variant, with the requirements' values, or else the largest worst case of
/// every coordinate and the largest sigma behind every filter.
class SweepTable {
 public:
  SweepTable(const SpecVariants&, const SweepGrid&);

  /// The cells of a variant, to be given to `add` in order.
  std::string row(const SweptVariant&) const;
  /// @param rows  of one or several variants
  void add(const std::string& rows);
  std::string text(const Style&) const;

 private:
  std::vector<std::string> figures(const SpecCheck&) const;

  const SpecVariants& variants_;
  const SweepGrid& grid_;
  std::vector<std::vector<std::string>> cells_;
};

}  // namespace qerr
