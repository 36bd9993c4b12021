#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

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

}  // namespace qerr
