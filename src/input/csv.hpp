#pragma once

#include <string>
#include <vector>

#include "qerr/core/error.hpp"

namespace qerr {

/// A CSV table of numbers in memory (RFC 4180): `#` lines before the header are comments.
struct CsvTable {
  std::vector<std::string> header;
  std::vector<std::vector<double>> rows;
  std::vector<int> lines;  ///< line of each row, from 1
};

/// @throws Error (input) with the line for a ragged row, an empty or malformed cell, a repeated column, no
/// rows
CsvTable read_csv_table(const std::string& path);

/// A header cell `NAME [UNIT]` in its parts; the unit is empty when there are no brackets.
struct ColumnName {
  std::string name;
  std::string unit;
};
ColumnName column_name(const std::string& cell);

}  // namespace qerr
