#include "report/text_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/text.hpp"

namespace qerr {

std::string aligned(const std::vector<std::vector<std::string>>& rows, const std::string& indent) {
  std::vector<std::size_t> width;
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (width.size() <= i) width.push_back(0);
      width[i] = std::max(width[i], display_width(row[i]));
    }
  std::string out;
  for (const auto& row : rows) {
    std::string line = indent;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string gap(width[i] - display_width(row[i]), ' ');
      line += (i ? "  " : "") + (i ? gap + row[i] : row[i] + gap);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + '\n';
  }
  return out;
}

std::string readable(double value, const std::string& unit) {
  if (!std::isfinite(value)) return "unbounded";
  if (value == 0) return "0 " + unit;
  static constexpr std::array<const char*, 8> prefixes{"p", "n", "u", "m", "", "k", "M", "G"};
  // Rounding to three digits may carry into the next thousand: 999.96 u is 1.00 m.
  char rounded[32];
  std::snprintf(rounded, sizeof rounded, "%.2e", value);
  const double kept = std::atof(rounded);
  const int thousand =
      std::clamp(static_cast<int>(std::floor(std::log10(std::abs(kept)) / 3 + 1e-12)), -4, 3);
  const double scaled = kept / std::pow(1000.0, thousand);
  const int decimals =
      std::clamp(2 - static_cast<int>(std::floor(std::log10(std::abs(scaled)) + 1e-12)), 0, 2);
  char text[48];
  if (std::abs(scaled) >= 1e4 || std::abs(scaled) < 1e-3)
    std::snprintf(text, sizeof text, "%.2e", scaled);
  else
    std::snprintf(text, sizeof text, "%.*f", decimals, scaled);
  return std::string(text) + ' ' + prefixes[static_cast<std::size_t>(thousand + 4)] + unit;
}

std::string shortest_of(double value, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

std::string bar(double fraction, int width) {
  static constexpr std::array<const char*, 8> eighths{"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
  const int cells = static_cast<int>(std::lround(std::clamp(fraction, 0.0, 1.0) * width * 8));
  std::string text;
  for (int i = 0; i < cells / 8; ++i) text += "█";
  return text + eighths[static_cast<std::size_t>(cells % 8)];
}

}  // namespace qerr
