#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/error.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

/// The bytes of an input: a regular file, a pipe, or `-` for standard input.
class ByteSource {
 public:
  /// @throws Error (file_system) if it cannot be opened, or is a directory or a device
  explicit ByteSource(const std::string& path);
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;
  ~ByteSource();

  /// Reads at most `most` bytes. @returns their number; 0 at the end
  /// @throws Error (file_system) if the system reports an error, or a file ends before the size that it had
  std::size_t read(char* buffer, std::size_t most);

  bool regular() const { return regular_; }  ///< a file that can be read again, and no pipe
  /// Bytes of a regular file, of standard input those that are left; 0 of a pipe.
  std::uint64_t size() const { return size_; }
  /// Bytes read so far.
  std::uint64_t position() const { return position_; }

  const std::string& name() const { return name_; }

 private:
  std::string name_;
  int descriptor_ = -1;
  bool regular_ = false;
  std::uint64_t size_ = 0, position_ = 0;
};

/// The text of an input document: a regular file, a pipe, or `-` for standard input, with at most 16 MB of
/// valid UTF-8 without NUL. A leading byte-order mark is removed.
/// @throws Error (file_system) if it cannot be read, (input) if its bytes are not such text
std::string read_text(const std::string& path);

/// Checks size and encoding of a text.
/// @throws Error (input), with line and column of the first invalid byte
void check_text(const std::string& text, const std::string& file);

/// The place of a byte that follows well-formed UTF-8; a column is a code point.
/// @pre byte <= text.size()
Place place_of_byte(const std::string& text, std::size_t byte, const std::string& file);

/// How the lines of a table are laid out around its cells: as JSON objects, as `t=0.1 counts=12`, between
/// brackets or pipes, behind `17:16:42.123 -> `, or ended by carriage returns alone. `plain` makes cells of
/// them in place: what is no cell becomes a blank, so that the column of every cell stays what it is in the
/// file.
class LineLayout {
 public:
  LineLayout() = default;
  /// Recognizes the layout of a text by its first lines.
  explicit LineLayout(std::string_view head);

  bool is_plain() const { return !returns_ && labels_.empty() && !framed_ && arrow_ == '\0'; }
  /// The labels of the cells, which every line repeats: the header that the table does not have.
  const std::vector<std::string>& labels() const { return labels_; }
  /// "labels before the values", for a report; "" if it is plain.
  std::string description() const;
  char line_end() const { return returns_ ? '\r' : '\n'; }

  /// Makes a line, its end included, one of cells.
  void make_plain(char* begin, char* end) const;

 private:
  bool returns_ = false;  ///< lines end with a carriage return
  bool framed_ = false;   ///< in brackets or pipes
  char arrow_ = '\0';     ///< what takes the place of `->`
  std::vector<std::string> labels_;
};

/// A text file as UTF-8, whatever it is written in: UTF-8 as it stands, UTF-16 behind its byte-order mark (a
/// spreadsheet's "Unicode text"), and Windows-1252 where the bytes are no UTF-8 (its CSV in Western Europe).
class TextSource {
 public:
  /// @param recognize  also texts that are not UTF-8; else their bytes are passed on as they are
  TextSource(const std::string& path, bool recognize);

  /// Reads at most `most` bytes of UTF-8; 4 or more, as many as a character can have.
  /// @returns their number; 0 at the end
  /// @throws Error like ByteSource; (input) for a binary file of a known kind, with how to export it
  std::size_t read(char* buffer, std::size_t most);

  const ByteSource& source() const { return source_; }
  /// `UTF-16` or `Windows-1252`; "" for UTF-8. Known once something is read.
  std::string_view encoding() const;
  /// How its lines are laid out, which `read` makes plain; known once something is read.
  const LineLayout& layout() const { return layout_; }

 private:
  enum class Encoding { utf8, utf16_little, utf16_big, windows_1252 };

  void recognize_encoding();
  bool refill();
  std::size_t read_text(char* buffer, std::size_t most);
  std::size_t read_lines(char* buffer, std::size_t most);
  std::size_t decoded(std::size_t at, std::string& utf8) const;

  ByteSource source_;
  bool recognize_, begun_ = false, ended_ = false;
  Encoding encoding_ = Encoding::utf8;
  std::string bytes_;  // read, and not yet passed on from `at_` on
  std::size_t at_ = 0;
  LineLayout layout_;
  std::string text_;       // UTF-8 whose lines are not yet made plain
  std::size_t plain_ = 0;  // of it, made plain and passed on up to `passed_`
  std::size_t passed_ = 0;
  bool text_ended_ = false;
};

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

/// The parts of a header cell `NAME [UNIT]`; the unit is empty if there are no brackets.
struct ColumnName {
  std::string name;
  std::string unit;
};
ColumnName column_name(const std::string& cell);

inline bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

struct CsvLimits {
  std::size_t block = 1 << 18;        ///< bytes per read
  std::size_t longest_row = 1 << 20;  ///< [bytes]
  bool empty_cells = false;           ///< an empty cell of a chosen column, or `nan`, is NaN and no error
  std::string empty_remedy = {};      ///< what else helps against an empty cell
  bool semicolons = false;            ///< a header with more of them than commas is separated by them
  bool recognize = false;             ///< encoding, separator, decimal mark, header: see recognize_table
};

/// Whether a cell has no value: it is empty, or what programs write in its place, such as `NaN`, `N/A`,
/// `null`, `-`.
bool is_missing(std::string_view cell);

struct WrittenNumbers {
  int most_decimals = -1000, least_decimals = 1000, most_digits = 0;
  std::uint64_t largest = 0;  ///< all digits as one integer

  DecimalText text() const;
};

/// Reads the number at `p`, with a decimal point, finite and correctly rounded; any byte that is no part of a
/// number ends it.
/// @returns its end, or null if there is no number, it is out of the range of double, or a zero byte follows
const char* read_number(const char* p, double& value, WrittenNumbers&);

/// A CSV table (RFC 4180) of any length, read row by row through a buffer of a few blocks.
///
/// Accepted are a byte-order mark, comment lines (`#`) before the header, blank lines, and LF or CR LF; where
/// the limits say so, any format that recognize_table finds. Columns that are not chosen may contain any
/// text. Numbers are decimal, finite and correctly rounded.
class CsvReader {
 public:
  /// Reads up to and including the header.
  /// @throws Error (file_system) if the file cannot be read, (input) if it does not begin with a header
  explicit CsvReader(const std::string& path, const CsvLimits& = {});

  const std::string& file() const { return source().name(); }
  const ByteSource& source() const { return source_.source(); }
  /// What was recognized: "UTF-16, separated by tabulators, decimal commas"; "" for a plain table.
  std::string recognized() const;

  /// The cells of the header, without leading and trailing blanks.
  const std::vector<std::string>& header() const { return header_; }
  Place header_place(std::size_t column) const;
  /// `,`, or `;` where the limits permit it; then numbers are to be read as texts.
  char separator() const { return format_.separator; }

  /// The first rows as texts, at most `most`, of those that have been read ahead to recognize the format.
  /// @pre no row has been read
  std::vector<std::vector<std::string>> first_rows(std::size_t most) const;

  /// Selects the columns to read as numbers, in the order in which `next` stores them, and those to read as
  /// texts; no column can be both.
  void choose(const std::vector<std::size_t>& columns, const std::vector<std::size_t>& texts = {});

  /// Reads the next row: stores the number of the i-th chosen column in values[i * stride].
  /// @returns false at the end
  /// @throws Error (input) with the place of a row with too few or too many cells, a cell that is not a
  /// number, an unclosed quotation mark, or a row that is too long
  bool next(double* values, std::ptrdiff_t stride = 1);

  /// Reads the next row as texts, one per column of the header, without surrounding blanks and quotation
  /// marks.
  /// @param places  receives the place of each cell
  /// @returns false at the end
  /// @throws Error (input) like the above, but for numbers
  bool next_texts(std::vector<std::string>& cells, std::vector<Place>& places);

  /// Line of the last row that was read, from 1.
  int line() const;
  /// Place and text of the cell of a chosen column in the last row that was read.
  Place place(std::size_t chosen) const;
  std::string text(std::size_t chosen) const;

  /// Decimals and digits of the numbers read so far from a chosen column.
  DecimalText written(std::size_t chosen) const { return written_[chosen].text(); }

  /// The i-th column of texts in the last row that was read; a byte that is not zero follows it in memory. A
  /// number has a decimal point.
  std::string_view chosen_text(std::size_t i) const { return texts_[i]; }
  /// Place of the cell of any column in the last row that was read.
  Place cell_place(std::size_t column) const;

 private:
  struct Cell {
    std::string text;        // without quotation marks and surrounding blanks
    const char* begin = {};  // in the buffer
    bool quoted = false;
  };

  bool fill();
  void recognize();
  void read_header();
  void take_header(const char* begin, const char* end);
  void number_columns();
  void add_units();
  void take_keyed_rows();
  void fit_header();
  void look_at_cells();
  std::string plain_text(const Cell&, std::size_t column) const;
  bool has_commas(std::size_t column) const { return !comma_columns_.empty() && comma_columns_[column]; }
  bool only_empty_rows_follow();
  bool is_blank_in_cell(char c) const { return is_blank(c) && !separates(c); }
  bool separates(char c) const { return c == format_.separator || (format_.separator == ' ' && c == '\t'); }
  const char* record_end();
  const char* fast_row(double* values, std::ptrdiff_t stride);
  bool next_record();
  bool general_row(double* values, std::ptrdiff_t stride);
  std::vector<Cell> cells_of_row() const;
  std::string with_decimal_point(const Cell&, std::size_t chosen);
  void general_cell(const Cell&, std::size_t chosen, double& value);
  std::vector<Cell> cells_of(const char* begin, const char* end) const;
  [[noreturn]] void ragged(std::size_t cells) const;
  Place place_at(const char* cell) const;

  TextSource source_;
  CsvLimits limits_;
  TableFormat format_;
  std::string header_line_;     // with which a logger may start again
  bool behind_blank_ = false;   // a blank line is before the present row
  bool remarks_ = false;        // the present row is one of words behind a blank line
  std::size_t left_out_ = 0;    // lines of words behind a blank line
  std::size_t empty_rows_ = 0;  // at the end, of separators alone
  std::int64_t filled_ = 0;     // a line that is none of them
  std::vector<char> buffer_;
  std::size_t row_ = 0;        // start in the buffer of the current row
  std::size_t next_ = 0;       // start of the next row
  std::size_t end_ = 0;        // of the data; it is followed by zeros, which end every number and text
  bool ended_ = false;         // the source has no more data
  bool unterminated_ = false;  // the last line has no line end
  std::int64_t line_ = 1, next_line_ = 1;
  std::vector<std::string> header_;
  std::vector<Place> header_places_;
  /// [column of the file]: the unit behind each number of a column, `12.5 deg`; empty: none has any.
  std::vector<std::string> cell_units_;
  std::vector<bool> comma_columns_;  // those with decimal commas beside points; empty: there are none
  std::vector<std::ptrdiff_t>
      plan_;  // for every column of the file: index i of a number, -1: not read, -2 - i of a text
  std::vector<std::size_t> chosen_;      // for every chosen column: its index in the file
  std::vector<WrittenNumbers> written_;  // for every chosen column
  std::vector<std::size_t> text_columns_;
  std::vector<std::string_view> texts_;  // of the last row, in the buffer or in text_cells_
  std::vector<std::string> text_cells_;
};

}  // namespace qerr
