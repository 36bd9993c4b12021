#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "input/table_format.hpp"
#include "input/text_source.hpp"
#include "qerr/core/error.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

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
