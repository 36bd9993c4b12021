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
#include "qerr/report/analysis.hpp"
#include "report/sweep/grid.hpp"

namespace qerr {

/// A variant of a sweep with its figures; or what is wrong with it, in one line.
struct SweptVariant {
  std::uint64_t variant = 0;
  /// Empty: it cannot be computed. Without results if a requirement cannot be decided. Statistics that were
  /// not asked for are unset.
  std::optional<SpecCheck> check;
  std::string fault;  ///< "" if there is none
};

/// Reads a variant and evaluates it, as `analyze` and `check` do.
/// @param judged  evaluate its requirements; else only its figures
/// @throws Error (file_system)
SweptVariant evaluate_variant(const SpecVariants&, const SweepGrid&, std::uint64_t variant, bool judged,
                              const WorkspaceOptions&);

/// A variant as of `evaluate_variant`; where `without_workspace` says so, the bounds over the configurations
/// are left out, and the requirements with them.
SweptVariant prepared_variant(const SpecVariants&, const SweepGrid&, std::uint64_t variant, bool judged,
                              const WorkspaceOptions&,
                              const std::function<bool(const Analysis&)>& without_workspace);

/// Evaluates the requirements of a variant whose bounds are computed.
void judge(SweptVariant&, bool judged);

/// Evaluates variants of a sweep many at a time. Where only encoders, gears, filters, effects, motions and
/// requirements vary, they share the columns of the Jacobian: a variant costs a matrix product in place of
/// the kinematics at all configurations, about a tenth of an `analyze`.
///
/// Variants share columns if the last axes of the sweep are of this kind and have at least 64 combinations.
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
  std::optional<Spec> readable(const std::vector<std::size_t>& steps) const;
  std::vector<IndependentError> sources(std::vector<std::size_t> steps) const;

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

}  // namespace qerr
