#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace qerr {

/// A table of figures that fits the terminal: the first column to the left, the others to the right. Where it
/// would be wider, the words of its header are stacked; where that is not enough, further columns follow in a
/// table of their own below, behind the same first column.
/// @param rows  the first one is the header
std::string fitted_table(const std::vector<std::vector<std::string>>& rows, std::size_t width,
                         const std::string& indent = "  ");

}  // namespace qerr
