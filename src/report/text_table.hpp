#pragma once

#include <string>
#include <vector>

#include "core/text.hpp"
#include "qerr/report/write.hpp"

/// Parts of tables for a terminal.
namespace qerr {

/// Aligns cells in columns: the first column to the left, the others to the right, two blanks between.
std::string aligned(const std::vector<std::vector<std::string>>& rows, const std::string& indent = "  ");

/// A fraction in percent, with three significant digits: `12.3 %`; `<0.001 %` and `>10000 %` beyond these
/// ends, "" for NaN.
std::string percent(double fraction);

/// A bar of `width` cells, filled to `fraction`, in eighths of a cell.
std::string bar(double fraction, int width);

/// ANSI codes (SGR).
enum class Paint { bold, red, green, yellow };

/// The text in bold, and in the colour if one is given, if the style has colours.
std::string painted(const std::string& text, Paint, const Style&);

/// The title of a section: an empty line, and the text in bold, in lines of the style's width.
std::string heading(const std::string& text, const Style&);

/// A name of the user's, safe for a terminal and not wider than a column should be.
std::string shown(const std::string& name);

/// A name of the user's, safe for a terminal and of at most `width` columns: the middle of a longer one gives
/// way to `..`, as names often differ in their last digits.
std::string shortened(const std::string& name, std::size_t width);

/// `a, b and c`.
std::string listed(const std::vector<std::string>& items);

}  // namespace qerr
