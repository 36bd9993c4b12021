#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace qerr {

/// Length in bytes of the well-formed UTF-8 sequence that starts at byte `at` (1 to 4; no overlong forms, no
/// surrogates); 0 if the bytes are not well formed.
std::size_t utf8_length(std::string_view text, std::size_t at);

/// The character that starts at byte `at`; 0 if the bytes are not well formed.
unsigned code_point(std::string_view text, std::size_t at);

/// Length in bytes of the character at byte `at` if a reader cannot see it, or it changes what others look
/// like: a control character (C0, DEL, C1), a character without width, or one that changes the direction of
/// writing or breaks the line (Unicode Technical Report 36); also 1 if the bytes are not well formed. Else 0.
std::size_t hidden_length(std::string_view text, std::size_t at);

/// Width of the text on a terminal, counted as one column per code point.
std::size_t display_width(std::string_view text);

/// What becomes of a word that is longer than a line.
enum class LongWords {
  whole,  ///< it has a line of its own, which is wider
  cut
};

/// The words of the text in lines of at most `width` columns, the first one of `first_width`.
std::vector<std::string> wrapped_lines(std::string_view text, std::size_t width, std::size_t first_width,
                                       LongWords = LongWords::whole);

/// The wrapped lines as one text, each with a line break, behind an indent, which `width` includes. The first
/// line starts with `first` in place of the indent.
std::string wrapped(std::string_view text, std::size_t width, const std::string& indent,
                    const std::string& first, LongWords = LongWords::whole);

/// The text in single quotes for a shell.
std::string shell_quoted(const std::string& text);

/// A word of a shell's command line: in single quotes if it has other characters than letters, digits and
/// -+.,:/@%=_
std::string shell_word(const std::string& text);

/// Count and noun: "1 joint", "3 joints".
std::string counted(std::size_t count, std::string_view noun);

/// The text in single quotes, as messages show what was found.
std::string quoted(const std::string& text);

/// `value` rounded to `digits` significant digits, as printf's %g does in the C locale, in every locale.
std::string significant(double value, int digits);

/// `value` rounded to `decimals` decimals, as printf's %f does in the C locale, in every locale.
std::string fixed_point(double value, int decimals);

/// A unit with an SI prefix from p to G, and its factor.
struct PrefixedUnit {
  double factor = 1;
  std::string unit;
};

/// The prefix with which a value, rounded to three digits, lies between 1 and 1000.
PrefixedUnit prefixed(double value, const std::string& unit);

/// A number for people, with three significant digits: `12.3`, `1.23e+06`; infinity is `unbounded`, NaN `not
/// known`.
std::string readable_number(double value);

/// A quantity for people: three significant digits and an SI prefix from p to G, such as `12.3 um`,
/// `4.56 mrad/s`, `0 m`; infinity is `unbounded`, NaN `not known`.
std::string readable(double value, const std::string& unit);

/// The nearest double with `digits` significant decimal digits; `value` itself if it is not finite.
double rounded_to(double value, int digits);

/// The text without the blanks, tabulators and line ends around it.
std::string_view trimmed(std::string_view text);

/// With the letters A to Z as a to z.
std::string lower_case(std::string_view text);

/// Two hexadecimal digits in upper case, such as `0A`.
std::string hexadecimal(unsigned char byte);

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
