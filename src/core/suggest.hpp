#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace qerr {

/// The known name with the smallest edit distance to `word`; "" if that exceeds a third of the length of
/// `word`.
std::string nearest(std::string_view word, const std::vector<std::string>& known);

/// "did you mean 'X'?" if a known name is near, otherwise "known: A, B, C" (at most 12 names).
std::string did_you_mean(std::string_view word, const std::vector<std::string>& known);

}  // namespace qerr
