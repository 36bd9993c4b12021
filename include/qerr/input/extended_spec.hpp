#pragma once

#include <string>
#include <vector>

#include "qerr/input/spec.hpp"

namespace qerr {

/// An effect to be written into a spec, with a note for the reader.
struct AddedEffect {
  Effect effect;
  std::string note;  ///< written above it as a comment; may have several lines
};

/// A velocity estimator to be written into a spec's `filters:`. A present entry of this name gets a new
/// low-pass; otherwise a new entry has the derivative and sample rate of the spec's velocity filter.
struct AddedFilter {
  std::string name;
  std::string family;  ///< of the low-pass
  int order = 0;
  double cutoff = 0;  ///< [Hz]
  std::string note;   ///< written as a comment
};

/// The text of a spec with effects appended to its `effects:`, for a file at `target`.
///
/// The user's text, comments and layout are kept. The spec's overrides (`--set`) are written into the text.
/// Paths of other files (URDF, motion, configurations) are rewritten relative to the folder of `target`.
/// Effects without a row in the list of effects, and effects or filters that the reader rejects, become
/// comments at the end with the reason.
/// @param remarks  a comment above the first effect, or at the end of a spec without effects
/// @param target  path of the new file; `-` means the working folder
/// @throws Error (input) if an override cannot be written into the layout of the text
std::string extended_spec(const Spec&, const std::vector<AddedEffect>&, const std::string& remarks,
                          const std::string& target, const std::vector<AddedFilter>& filters = {});

}  // namespace qerr
