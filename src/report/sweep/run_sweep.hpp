#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "report/sweep/column_sweep.hpp"
#include "report/sweep/swept_variant.hpp"

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

/// Variants that could not be computed, or have a requirement that cannot be decided.
struct FailedVariants {
  std::uint64_t count = 0;
  std::vector<std::string> first;  ///< of some of them: number, values and fault
};

/// Evaluates the variants of a job.
class SweepRun {
 public:
  explicit SweepRun(SweepJob);

  const SweepJob& job() const { return job_; }

  /// Passes on the texts of the variants in order, each as soon as those before it have been. Memory does not
  /// grow with the number of variants.
  /// @param begin     index in the shard of the first variant
  /// @param progress  called with the number of variants of the job that are done; may be empty
  FailedVariants run(std::uint64_t begin, const std::function<void(const std::string&)>& write,
                     const std::function<void(std::uint64_t done, std::uint64_t total)>& progress = {}) const;

  /// The text of one variant, by its index in the shard.
  std::string text(std::uint64_t index) const;

 private:
  SweepJob job_;
  ColumnSweep engine_;
};

}  // namespace qerr
