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

/// What is wrong with a text that should be a number with an optional unit, and what to write instead.
struct NumberAdvice {
  std::string rule;
  std::string remedy;  ///< "" if only the kind of value that is expected can be named
};

/// The habit behind a text that `parse_quantity` refuses: a decimal comma, blanks between digits, a ratio
/// `100:1`, a minus sign of a word processor, an expression, a unit under another name.
/// @param why  of parse_quantity
NumberAdvice advice_on_number(std::string_view text, const std::string& why);

}  // namespace qerr
