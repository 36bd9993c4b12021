#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace qerr {

/// The known name nearest to `word` in edit distance, or "" when none is near enough to be what was meant.
std::string nearest(std::string_view word, const std::vector<std::string>& known);

/// "did you mean 'X'?" when a known name is near, otherwise "known: A, B, C" (shortened when long).
std::string did_you_mean(std::string_view word, const std::vector<std::string>& known);

}  // namespace qerr
