#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/text.hpp"

/// Text that fits a terminal.
namespace qerr {

/// `wrapped_lines` and `wrapped` of core/text.hpp with the same width, or indent, for all lines.
std::vector<std::string> wrapped_lines(std::string_view text, std::size_t width);
std::string wrapped(std::string_view text, std::size_t width, const std::string& indent = "");

/// A text whose wider lines are broken at words, with their indent and two columns more.
std::string within(const std::string& text, std::size_t width);

/// A term, and behind it, from `column` on, its meaning; on a line of its own where the term is longer.
std::string defined(const std::string& term, std::string_view meaning, std::size_t width,
                    std::size_t column = 26);

/// A table whose cells are aligned to the left and wrapped, so that its rows fit the width; the widest
/// columns give way.
std::string wrapped_table(const std::vector<std::vector<std::string>>& rows, std::size_t width,
                          const std::string& indent = "  ");

}  // namespace qerr
