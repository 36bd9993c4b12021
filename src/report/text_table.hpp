#pragma once

#include <string>
#include <vector>

namespace qerr {

/// Lines up cells in columns: the first column to the left, the others to the right, two blanks between.
std::string aligned(const std::vector<std::vector<std::string>>& rows, const std::string& indent = "  ");

/// A figure for reading: three significant digits and a prefix, such as `12.3 um`, `4.56 mrad/s`, `0 m`,
/// `unbounded`.
std::string readable(double value, const std::string& unit);

/// A number with `digits` significant digits, without a unit.
std::string shortest_of(double value, int digits);

/// A bar of `width` cells, filled to `fraction`, in eighths of a cell.
std::string bar(double fraction, int width);

}  // namespace qerr
