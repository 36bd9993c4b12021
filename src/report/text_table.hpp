#pragma once

#include <string>
#include <vector>

#include "core/text.hpp"

namespace qerr {

/// Lines up cells in columns: the first column to the left, the others to the right, two blanks between.
std::string aligned(const std::vector<std::vector<std::string>>& rows, const std::string& indent = "  ");

/// A bar of `width` cells, filled to `fraction`, in eighths of a cell.
std::string bar(double fraction, int width);

}  // namespace qerr
