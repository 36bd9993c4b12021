#pragma once

#include <memory>
#include <string>
#include <vector>

#include "input/csv.hpp"
#include "qerr/input/read_log.hpp"

namespace qerr {

class JoinedLog;

/// The files of a log as one table of columns, whatever their format.
///
/// One wide file without empty cells is streamed. Files in the long format (`time,signal,value`), several
/// files, and wide files with empty cells are joined by time (`JoinedLog`).
class LogTable {
 public:
  /// @throws Error like CsvReader; (input) if files that are joined have no time
  LogTable(const LogFiles&, const CsvLimits&);
  ~LogTable();

  /// The names of the files, for messages.
  const std::string& file() const { return file_; }
  const std::vector<std::string>& header() const;
  Place header_place(std::size_t column) const;
  /// The functions below are those of CsvReader.
  void choose(const std::vector<std::size_t>& columns);
  bool next(double* values, std::ptrdiff_t stride);
  int line() const;
  Place place(std::size_t chosen) const;
  std::string text(std::size_t chosen) const;
  DecimalText written(std::size_t chosen) const;
  /// Bytes read so far and of the file; 0 of a pipe or of joined files, which are read before the first row.
  std::uint64_t position() const;
  std::uint64_t size() const;
  /// What joining did to the rows; complete after the last row.
  std::vector<std::string> warnings() const;

 private:
  std::string file_;
  std::unique_ptr<CsvReader> streamed_;
  std::unique_ptr<JoinedLog> joined_;
};

}  // namespace qerr
