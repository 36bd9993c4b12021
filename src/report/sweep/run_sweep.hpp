#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "qerr/report/write.hpp"
#include "report/sweep/column_sweep.hpp"

namespace qerr {

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

/// The outcome of a sweep.
struct SweepOutcome {
  SweepCounts counts;
  std::vector<std::string> faults;  ///< of some variants that failed: number, values and fault
};

/// What became of a variant, as one letter: `e` it failed, `n` it does not meet its requirements, `y` it
/// does, `u` they were not evaluated.
char verdict_of(const SweptVariant&, bool judged);
/// Counts a variant by that letter. @returns false for another letter
bool count_verdict(SweepCounts&, char verdict);

/// Evaluates the variants of a job.
class SweepRun {
 public:
  explicit SweepRun(SweepJob);

  const SweepJob& job() const { return job_; }

  /// Passes on the texts of the variants in order, each as soon as those before it have been. Memory does not
  /// grow with the number of variants.
  /// @param before    the variants of the job that are not computed: the first ones
  /// @param write     called with the texts of some variants, and the counts up to them
  /// @param progress  called with the number of variants of the job that are done; may be empty
  SweepOutcome run(const SweepCounts& before,
                   const std::function<void(const std::string&, const SweepCounts&)>& write,
                   const std::function<void(std::uint64_t done, std::uint64_t total)>& progress = {}) const;

 private:
  SweepJob job_;
  ColumnSweep engine_;
};

}  // namespace qerr
