#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "input/csv.hpp"
#include "qerr/core/unit.hpp"

namespace qerr {

/// Whether a table has the columns `time`, `signal` and `value`.
bool is_long_format(const CsvReader&);

/// Tables joined by time: a row for every distinct time stamp of the chosen columns, in which each column has
/// its last value. Rows before the first value of every chosen column are dropped.
///
/// All values are kept, 8 bytes each, and 12 bytes per row of a wide file or value of a long one.
class JoinedLog {
 public:
  /// @param hold  an empty cell of a wide table means the last value of its column
  explicit JoinedLog(bool hold) : hold_(hold) {}

  /// Reads all rows of a table, wide or long.
  /// @param timed  whether a table without time is an error
  /// @throws Error (input) for time that decreases within a column, and like CsvReader
  void add(CsvReader&, bool timed);

  const std::vector<std::string>& header() const { return header_; }
  Place header_place(std::size_t column) const { return columns_[column].place; }
  /// @throws Error (input) for a cell of a chosen column that is not a number
  void choose(const std::vector<std::size_t>& columns);
  bool next(double* values, std::ptrdiff_t stride);
  Place place(std::size_t chosen) const;
  std::string text(std::size_t chosen) const;
  DecimalText written(std::size_t chosen) const;
  std::vector<std::string> warnings() const;

 private:
  /// Time stamps that one or more columns share.
  struct Stamps {
    std::string file;
    std::vector<double> times;
    std::vector<std::uint32_t> lines;
    std::size_t next = 0;  // index of the first row that is not joined yet
    bool used = false;
  };
  struct Column {
    std::size_t stamps = 0;
    Place place;
    bool is_time = false;
    std::vector<double> values = {};  // NaN: an empty cell, held
    CsvReader::Written written = {};
    std::optional<Error> fault = {};  // of the first cell that is no number
    double last = std::numeric_limits<double>::quiet_NaN();
  };

  std::size_t add_column(const std::string& header, std::size_t stamps, const Place&);
  std::size_t new_stamps(const std::string& file);
  std::size_t add_time(const CsvReader&, std::size_t place);
  double time_of(const std::string& cell, const Place&, std::size_t stamps, const std::string& header);
  void add_wide(CsvReader&, std::optional<std::size_t> time);
  void add_long(CsvReader&, std::size_t time);
  void store(Column&, const std::string& header, const std::string& cell, const Place&) const;

  bool hold_;
  std::vector<std::string> header_;
  std::vector<Column> columns_;
  std::vector<Stamps> stamps_;
  std::vector<std::size_t> chosen_;
  std::optional<std::size_t> time_;  // column
  Unit unit_;                        // of the time stamps of the first table
  double factor_ = 1;                // from the time unit of the table that is read to that of the first
  std::uint64_t dropped_ = 0;
  std::vector<std::string> sorted_;  // files whose signals follow one another
  double now_ = 0;
};

}  // namespace qerr
