#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "qerr/report/write.hpp"

namespace qerr {

/// Text and tables that fit a terminal.

/// Rows of cells; of tables with a header it is the first one.
using TableRows = std::vector<std::vector<std::string>>;

/// `wrapped_lines` and `wrapped` of core/text.hpp with the same width, or indent, for all lines.
std::vector<std::string> wrapped_lines(std::string_view text, std::size_t width);
std::string wrapped(std::string_view text, std::size_t width, const std::string& indent = "");

/// A text whose wider lines are broken at words, with their indent and two columns more.
std::string within(const std::string& text, std::size_t width);

/// A term, and behind it, from `column` on, its meaning; on a line of its own where the term is longer.
std::string defined(const std::string& term, std::string_view meaning, std::size_t width,
                    std::size_t column = 26);

/// A table whose cells are aligned to the left and wrapped, so that its rows fit the width; the widest
/// columns give way.
std::string wrapped_table(const TableRows& rows, std::size_t width, const std::string& indent = "  ");

/// Aligns cells in columns: the first column to the left, the others to the right, two blanks between. A line
/// for each row, without its line break.
std::vector<std::string> aligned_lines(const TableRows& rows, const std::string& indent = "  ");
std::string aligned(const TableRows& rows, const std::string& indent = "  ");

std::vector<std::string> lines_of(std::string_view text);

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

/// Items by what they have in common, in the order in which that was first met.
using ItemGroups = std::vector<std::pair<std::string, std::vector<std::string>>>;
/// Adds an item once to the group of that name.
void add_to_group(ItemGroups& groups, const std::string& name, const std::string& item);

/// A table of figures that fits the terminal: the first column to the left, the others to the right. Where it
/// would be wider, the words of its header are stacked; where that is not enough, further columns follow in a
/// table of their own below, behind the same first column.
/// @param rows  the first one is the header
std::string fitted_table(const TableRows& rows, std::size_t width, const std::string& indent = "  ");

/// A section of a report's table: its title, a fitted table, and a remark below it; "" if no row follows the
/// header.
std::string table_section(const std::string& title, const TableRows& rows, const Style&,
                          const std::string& remark = "");

/// Points and a line over the same abscissae, in characters.
struct TextPicture {
  std::vector<double> at;      ///< ascending
  std::vector<double> points;  ///< one per abscissa, NaN: none
  std::vector<double> line;    ///< the same; empty: no line
  std::string points_name, line_name;
  std::string ordinate, abscissa;  ///< names of the axes, with units
};

/// The smallest of 1, 2, 5 times a power of ten that is at least `least`, but for a relative tolerance.
double round_step(double least, double tolerance = 0);

/// The picture, at most ten rows high between its legend and its abscissa, in lines of at most
/// `style.width` columns, behind an indent. Ticks are at 1, 2, 2.5 or 5 times a power of ten; zero is always
/// in the range. A gap in the line remains a gap; between abscissae that are wider apart than a
/// column, the line is interpolated. "" if fewer than two abscissae have a finite value.
std::string text_picture(const TextPicture&, const Style&, const std::string& indent = "    ");

}  // namespace qerr
