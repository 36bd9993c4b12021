#include "report/text_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "qerr/core/error.hpp"
#include "report/wrapped_text.hpp"

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

std::string percent(double fraction) {
  if (std::isnan(fraction)) return "";
  const double value = 100 * std::abs(fraction);
  const std::string sign = fraction < 0 ? "-" : "";
  if (value > 10000) return sign.empty() ? ">10000 %" : "<-10000 %";
  if (value > 0 && value < 0.001) return "<0.001 %";
  // From 1000 on significant() would write an exponent.
  return sign + (value >= 999.5 ? fixed_point(value, 0) : significant(value, 3)) + " %";
}

std::string bar(double fraction, int width) {
  static constexpr std::array<const char*, 8> eighths{"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
  const int cells = static_cast<int>(std::lround(std::clamp(fraction, 0.0, 1.0) * width * 8));
  std::string text;
  for (int i = 0; i < cells / 8; ++i) text += "█";
  return text + eighths[static_cast<std::size_t>(cells % 8)];
}

std::string painted(const std::string& text, Paint paint, const Style& style) {
  static constexpr std::array<const char*, 4> codes{"1", "1;31", "1;32", "1;33"};
  if (!style.color) return text;
  return "\x1b[" + std::string(codes[static_cast<std::size_t>(paint)]) + 'm' + text + "\x1b[0m";
}

std::string heading(const std::string& text, const Style& style) {
  std::string out = "\n";
  for (const std::string& line : wrapped_lines(text, style.width))
    out += painted(line, Paint::bold, style) + '\n';
  return out;
}

std::string shortened(const std::string& name, std::size_t width) {
  const std::string text = escaped(name, 4096);
  if (display_width(text) <= width) return text;
  std::vector<std::string> letters;  // of one or more bytes
  for (const char c : text) {
    if ((static_cast<unsigned char>(c) & 0xC0u) != 0x80u) letters.emplace_back();
    letters.back() += c;
  }
  const std::size_t kept = width - 2, front = kept / 2, back = kept - front;
  std::string out;
  for (std::size_t i = 0; i < front; ++i) out += letters[i];
  out += "..";
  for (std::size_t i = letters.size() - back; i < letters.size(); ++i) out += letters[i];
  return out;
}

std::string shown(const std::string& name) { return escaped(name, 60); }

std::string listed(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i)
    text += (i == 0 ? "" : i + 1 == items.size() ? " and " : ", ") + items[i];
  return text;
}

}  // namespace qerr
