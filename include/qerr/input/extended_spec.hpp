#pragma once

#include <string>
#include <vector>

#include "qerr/input/spec.hpp"

namespace qerr {

/// An effect to be written into a spec, and what a person should know of it.
struct AddedEffect {
  Effect effect;
  std::string note;  ///< written above it as a comment; may have several lines
};

/// A velocity estimator to be written into a spec's `filters:`. The entry that has this name gets another
/// low-pass; a name that is not there becomes an entry with the spec's own derivative and sample rate.
struct AddedFilter {
  std::string name;
  std::string family;  ///< of the low-pass
  int order = 0;
  double cutoff = 0;  ///< [Hz]
  std::string note;   ///< written as a comment
};

/// The text of a spec with more effects at the end of its `effects:`, ready to stand at `target`.
///
/// The user's text, comments and layout are kept. The spec's overrides (`--set`) are written into the text.
/// Paths of other files (URDF, motion, configurations) lead from the target's folder to the same files.
/// Effects that no row of the list can simulate, and those that the reader refuses, become comments at the
/// end that say so; so do filters that it refuses.
/// @param remarks  a comment above the first effect, or at the end where there is none
/// @param target  path at which the text will stand; `-` stands for the working folder
/// @throws Error (input) where an override cannot be written into the text as it is laid out
std::string extended_spec(const Spec&, const std::vector<AddedEffect>&, const std::string& remarks,
                          const std::string& target, const std::vector<AddedFilter>& filters = {});

}  // namespace qerr
