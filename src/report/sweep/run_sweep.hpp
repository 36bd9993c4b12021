#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bound/column_statistics.hpp"
#include "input/spec_variants.hpp"
#include "qerr/input/spec.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"

namespace qerr {

/// Variants whose number is `first` modulo `stride`: shard K of N has first K - 1 and stride N, so that each
/// has its share of every part of the grid.
struct Shard {
  std::uint64_t first = 0, stride = 1;

  std::uint64_t variant(std::uint64_t index) const { return first + index * stride; }
  /// How many of `total` variants it has.
  std::uint64_t size(std::uint64_t total) const {
    return total > first ? (total - first - 1) / stride + 1 : 0;
  }
};

/// A key that varies, as programs read it.
struct SweepColumn {
  std::string key, unit;
  std::size_t axis = 0;
  /// Of the steps of its axis [SI], if all of them are numbers, in units of one kind; else empty: they are
  /// texts, such as the family of a filter or a row of a catalogue.
  std::vector<double> values;

  std::string header() const { return unit.empty() ? key : key + " [" + unit + ']'; }
};

/// The variants of a sweep, numbered from 0: all combinations of the steps of its axes, of which the first
/// one varies slowest.
class SweepGrid {
 public:
  /// @throws Error (input; key `sweep`) if there is no axis, or more than 2^53 variants
  explicit SweepGrid(const Spec&);

  std::uint64_t count() const { return count_; }
  const std::vector<SweepAxis>& axes() const { return axes_; }

  /// The keys that vary, in the order of the axes.
  std::vector<std::string> keys() const;
  const std::vector<SweepColumn>& columns() const { return columns_; }
  std::vector<std::string> names(std::uint64_t variant) const;
  /// `KEY = VALUE, KEY = VALUE` for messages. @param text  of a value's name
  std::string description(std::uint64_t variant,
                          const std::function<std::string(const std::string&)>& text = std::identity()) const;

  std::vector<std::size_t> steps(std::uint64_t variant) const;
  /// The spec with the chosen steps of the axes. @param steps  as of `steps`
  Spec spec(const SpecVariants&, const std::vector<std::size_t>& steps) const;
  /// Likewise; empty if it has a fault.
  std::optional<Spec> readable(const SpecVariants&, const std::vector<std::size_t>& steps) const;

 private:
  /// A step as changes of the tree.
  struct Changes {
    std::vector<SpecChange> values;
    std::vector<Node> effects;
  };

  std::vector<SweepAxis> axes_;
  std::vector<SweepColumn> columns_;
  std::vector<std::vector<Changes>> changes_;  // [axis][step]
  std::uint64_t count_ = 1;
};

/// A variant of a sweep with its figures; or what is wrong with it, in one line.
struct SweptVariant {
  std::uint64_t variant = 0;
  /// Empty: it cannot be computed. Without results if a requirement cannot be decided. Statistics that were
  /// not asked for are unset.
  std::optional<SpecCheck> check;
  std::string fault;  ///< "" if there is none
};

/// Evaluates variants of a sweep many at a time. Where only encoders, gears, filters, effects, motions and
/// requirements vary, they share the columns of the Jacobian: a variant costs a matrix product in place of
/// the kinematics at all configurations, a quarter of an `analyze` with all statistics.
///
/// Variants share columns if the last axes of the sweep are of this kind and have at least 8 combinations.
/// The others, and those that `have_columns` excludes, are evaluated by `analyze`. Which one it is depends on
/// the spec alone, so that the result does not depend on threads or shards.
class ColumnSweep {
 public:
  /// @param wanted  statistics that are reported; where requirements are judged theirs are computed, too
  ColumnSweep(const SpecVariants&, const SweepGrid&, bool judged, std::vector<const StatisticKind*> wanted,
              unsigned threads);

  /// Variants that are best evaluated together.
  std::size_t batch() const { return shared_ > 1 ? forms_per_tile : 1; }

  /// May be called from several threads.
  /// @param inner_threads  of the evaluation of one variant
  /// @throws Error (file_system)
  std::vector<SweptVariant> evaluate(std::span<const std::uint64_t> variants, unsigned inner_threads) const;

 private:
  /// What the variants of one robot and one set of configurations share.
  struct Shared {
    std::uint64_t group = 0;
    std::unique_ptr<ErrorColumns> columns;  // null: not possible
    std::unique_ptr<ColumnStatistics> statistics;
  };

  std::shared_ptr<const Shared> shared(std::uint64_t group) const;
  std::shared_ptr<const Shared> computed(std::uint64_t group) const;
  std::vector<IndependentError> sources(std::vector<std::size_t> steps) const;
  SweptVariant evaluated(std::uint64_t variant, const WorkspaceOptions&, const Shared*) const;
  void judge(SweptVariant&) const;

  const SpecVariants& variants_;
  const SweepGrid& grid_;
  bool judged_;
  WantedStatistics wanted_;
  unsigned threads_;
  std::size_t first_light_;   // axis from which on variants share columns
  std::uint64_t shared_ = 1;  // variants that share columns
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const Shared> last_;
};

/// The part of a sweep that is to be computed, and how.
struct SweepJob {
  const SpecVariants& variants;
  const SweepGrid& grid;
  Shard shard = {};
  bool judged = false;                           ///< evaluate the requirements, too
  std::vector<const StatisticKind*> statistics;  ///< that the texts have
  unsigned threads = 0;                          ///< 0: one per core; the texts do not depend on it
  /// The text of a variant; called on any thread.
  std::function<std::string(const SweptVariant&)> text;

  std::uint64_t size() const { return shard.size(grid.count()); }
};

/// What became of the variants so far.
struct SweepCounts {
  std::uint64_t variants = 0;
  std::uint64_t failed = 0;    ///< could not be computed, or have a requirement that cannot be decided
  std::uint64_t unmet = 0;     ///< do not meet their requirements
  std::uint64_t unjudged = 0;  ///< whose requirements were not evaluated
};

struct SweepOutcome {
  SweepCounts counts;
  std::vector<std::string> faults;  ///< of some variants that failed: number, values and fault
};

/// What became of a variant, as one letter: `e` it failed, `n` it does not meet its requirements, `y` it
/// does, `u` they were not evaluated.
char verdict_of(const SweptVariant&, bool judged);
/// Counts a variant by that letter. @returns false for another letter
bool count_verdict(SweepCounts&, char verdict);

/// Evaluates the variants of a job, and passes on their texts in order, each as soon as those before it have
/// been. Memory does not grow with the number of variants.
/// @param before    the variants of the job that are not computed: the first ones
/// @param write     called with the texts of some variants, and the counts up to them
/// @param progress  called with the number of variants of the job that are done; may be empty
SweepOutcome run_sweep(const SweepJob&, const SweepCounts& before,
                       const std::function<void(const std::string&, const SweepCounts&)>& write,
                       const std::function<void(std::uint64_t done, std::uint64_t total)>& progress = {});

}  // namespace qerr
