#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "qerr/report/analysis.hpp"
#include "report/sweep/grid.hpp"

namespace qerr {

/// A variant of a sweep with its figures; or what is wrong with it, in one line.
struct SweptVariant {
  std::uint64_t variant = 0;
  std::optional<SpecCheck> check;  ///< empty: there is a fault. Statistics that were not asked for are unset
  std::string fault;
};

/// The first fault of an error, without its place, as the reports of a sweep have it.
std::string fault_text(const Error&);

/// Reads a variant and evaluates it, as `analyze` and `check` do.
/// @param judged  evaluate its requirements; else only its figures
/// @throws Error (file_system)
SweptVariant evaluate_variant(const SpecVariants&, const SweepGrid&, std::uint64_t variant, bool judged,
                              const WorkspaceOptions&);

}  // namespace qerr
