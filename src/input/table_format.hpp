#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/error.hpp"

namespace qerr {

/// How a table of numbers is written.
struct TableFormat {
  char separator = ',';          ///< of cells; ' ' is any run of blanks and tabulators
  char decimal = '.';            ///< mark of decimals
  bool decimal_unknown = false;  ///< no number of the sample has decimals
  bool maybe_thousands = false;  ///< every decimal comma of the sample may be a mark of thousands: `64,863`
  bool points_group = false;     ///< a number of the sample has points of thousands and a decimal comma
  bool has_header = true;
  bool header_is_comment = false;  ///< `# time q1 q2`, as numpy.savetxt writes it
  bool has_units = false;          ///< the row behind the header has the units of the columns
  int keyed_until =
      0;  ///< last line of rows `Name x Name y`, `Unit - Unit deg`, of a time and a value each; 0: none
  std::size_t header = 0;  ///< offset of the header's line, or of the first row
  int header_line = 1;
  int preamble = 0;       ///< lines before it that are neither comments nor blank
  std::size_t cells = 0;  ///< of most rows, a trailing separator included; 0: there are no rows
};

/// Recognizes the format of a table by its beginning: separator and decimal mark are those by which its lines
/// have most numbers in equally many cells, the header is the line of names before the longest run of such
/// lines. Where nothing is recognized it is a table that commas separate, with the header in its first line.
/// @param head  UTF-8; its last line may be cut off
TableFormat recognize_table(std::string_view head);

/// A blank within or around a cell; also the carriage return before a line feed.
inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// The end of a record, which begins a text: its first line end outside of quotation marks, which open behind
/// a separator. Both are npos if there is none.
struct RecordEnd {
  std::size_t at;
  std::size_t open;  ///< the quotation mark that is not closed
};
RecordEnd find_record_end(std::string_view text, std::string_view separators);

/// A cell without the blanks and quotation marks around it.
std::string_view bare_cell(std::string_view cell);

/// A cell without the apostrophe by which spreadsheets mark a number as text: `'12`.
std::string_view without_text_mark(std::string_view cell);

/// A cell `12.5 deg` or `12.5deg`: its number, and the unit in qerr's words; both empty for any other text.
struct NumberAndUnit {
  std::string_view number;
  std::string unit;
};
NumberAndUnit number_and_unit(std::string_view cell, char decimal);

/// Whether a cell of a header can be the unit of the name before it, from which a comma separates it.
bool is_unit_behind_comma(std::string_view cell);

/// Whether a text is a number with this decimal mark, without regard to its size.
bool is_numeric(std::string_view text, char decimal);

/// `1.200` or `12.500 mm`: three digits behind a point, which may be that of thousands.
bool may_be_thousands(std::string_view cell);

/// The fault that asks about such a number in a table of decimal commas.
Fault ambiguous_point(const Place&, const std::string& key, const std::string& cell);

/// Makes the decimal comma of `12,5` or `0,05 deg` a point. @returns false for a text that has none
bool replace_decimal_comma(std::string& cell);

/// Makes `-1.234.567,8`, `1 234,5`, `1'234.5` or `1,234.5` a plain number: groups of three digits between
/// marks of one kind. A single point or comma without decimals behind may be a decimal mark, and is left.
/// @returns the decimal mark, zero without decimals; empty for any other text, which is not changed
std::optional<char> remove_thousands(std::string& cell);

/// Makes `1.5D-03`, as Fortran writes it, `1.5E-03`, and `0x1AF`, a register, `431`. @returns false for any
/// other text
bool make_decimal_notation(std::string& cell);

/// Either of the first two, where there is something to change.
void make_plain_number(std::string& cell);

/// The commas in the numbers of a column, in a table of decimal points: decimal ones, of which one cannot be
/// of thousands, and no cell has a point; else they may be of thousands.
enum class Commas { none, ambiguous, decimal };
Commas commas_of(const std::vector<std::string>& cells);

}  // namespace qerr
