#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace qerr {

/// The known name with the smallest edit distance to `word`, not case-sensitive, or one that begins with it;
/// "" if the distance exceeds one letter and a third of the shorter of the two.
std::string nearest(std::string_view word, const std::vector<std::string>& known);

/// "did you mean 'X'?" if one or two known names are near, otherwise "known: A, B, C" (at most 12 names).
std::string did_you_mean(std::string_view word, const std::vector<std::string>& known);

}  // namespace qerr
