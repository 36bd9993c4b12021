#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "input/byte_source.hpp"
#include "qerr/core/error.hpp"
#include "qerr/simulate/log.hpp"

namespace qerr {

/// A header cell `NAME [UNIT]` in its parts; the unit is empty when there are no brackets.
struct ColumnName {
  std::string name;
  std::string unit;
};
ColumnName column_name(const std::string& cell);

struct CsvLimits {
  std::size_t block = 1 << 18;        ///< bytes that are asked for at once
  std::size_t longest_row = 1 << 20;  ///< [bytes]
};

/// A CSV table (RFC 4180) of any length, read row by row through a buffer of a few blocks.
///
/// A byte-order mark, `#` lines before the header, blank lines and either line end are allowed for. Columns
/// that nobody chose may hold any text. Numbers are decimal, finite and correctly rounded.
class CsvReader {
 public:
  /// Reads as far as the header.
  /// @throws Error (file_system) when the file cannot be read, (input) when it does not begin with a header
  explicit CsvReader(const std::string& path, const CsvLimits& = {});

  const std::string& file() const { return source_.name(); }

  /// The header's cells, without blanks around them.
  const std::vector<std::string>& header() const { return header_; }
  Place header_place(std::size_t column) const;

  /// The columns to read as numbers, in the order in which `next` shall give them.
  void choose(const std::vector<std::size_t>& columns);

  /// Reads the next row: values[i * stride] becomes the number of the i-th chosen column.
  /// @returns false at the end
  /// @throws Error (input) with the place of a ragged row, a cell that is no number, an open quote, a row
  /// that is too long
  bool next(double* values, std::ptrdiff_t stride = 1);

  /// Line of the row read last, from 1.
  int line() const;
  /// Place of a chosen column's cell in the row read last, and its text.
  Place place(std::size_t chosen) const;
  std::string text(std::size_t chosen) const;

  /// How the numbers of a chosen column were written so far.
  DecimalText written(std::size_t chosen) const;

 private:
  struct Cell {
    std::string text;        // without quotes and the blanks around
    const char* begin = {};  // in the buffer
    bool quoted = false;
  };
  /// How the numbers of a column were written, as the fast path keeps it.
  struct Written {
    int most_decimals = -1000, least_decimals = 1000, most_digits = 0;
    std::uint64_t largest = 0;  // all digits as one whole number
  };

  bool fill();
  void drop_mark();
  void read_header();
  const char* record_end(const char* begin);
  const char* plain_row(double* values, std::ptrdiff_t stride);
  bool careful_row(double* values, std::ptrdiff_t stride);
  void careful_cell(const Cell&, std::size_t chosen, double& value);
  std::vector<Cell> cells_of(const char* begin, const char* end) const;
  [[noreturn]] void ragged(std::size_t cells) const;
  Place place_at(const char* cell) const;
  static const char* plain_number(const char*, double& value, Written&);

  ByteSource source_;
  CsvLimits limits_;
  std::vector<char> buffer_;
  std::size_t row_ = 0;  // where in the buffer the row begins that is read, or was read last
  std::size_t at_ = 0;   // where the next one begins
  std::size_t end_ = 0;  // of what was read; beyond it a few zeros, at which every number and text ends
  bool ended_ = false, cut_off_ = false;
  std::int64_t line_ = 1, next_line_ = 1;
  std::vector<std::string> header_;
  std::vector<Place> header_places_;
  std::vector<std::ptrdiff_t> plan_;  // for every column of the file: the chosen column, or -1
  std::vector<std::size_t> chosen_;   // for every chosen column: that of the file
  std::vector<Written> written_;      // for every chosen column
};

}  // namespace qerr
