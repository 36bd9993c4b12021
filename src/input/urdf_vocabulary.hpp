#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "input/urdf_flaws.hpp"
#include "input/urdf_outline.hpp"

namespace qerr {

/// Allowed contents of an element: `many` and `once` are read, `whole` is kept with all that it contains,
/// `ignored` is skipped. Any other name is foreign (a tag of a simulator) unless it resembles a known one.
struct Vocabulary {
  using Names = std::vector<std::string>;
  std::string_view element;
  Names many, once, whole, ignored, attributes;

  static bool has(const Names& names, std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  }
};

/// The row of an element; null if the element has none.
const Vocabulary* vocabulary(std::string_view element);

/// Reports misspelt and duplicate elements and attributes, which a lenient reader would skip silently.
/// @throws Error (input) for values that xacro has not expanded
void check_vocabulary(const UrdfElement& root, const std::string& file, FlawList&);

}  // namespace qerr
