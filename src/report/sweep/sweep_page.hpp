#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "report/sweep/drawn_variants.hpp"
#include "report/sweep/run_sweep.hpp"

namespace qerr {

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
