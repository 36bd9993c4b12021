#pragma once

#include <string>

namespace qerr::fuzz {

/// A spec with one change that knows the format: a value replaced by another that the JSON Schema of the spec
/// allows, or by one that no robot has; a key added, or removed.
/// @returns an empty text if `spec` is no YAML mapping, or has anchors
std::string changed_by_schema(const std::string& spec, unsigned seed);

}  // namespace qerr::fuzz
