#include "core/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace qerr {

namespace {

/// Longest text: the 309 digits of the largest double, a sign, a point and its decimals.
std::string printed(double value, std::chars_format format, int precision) {
  std::array<char, 400> buffer;
  const auto [end, failure] =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, format, precision);
  return failure == std::errc{} ? std::string(buffer.data(), end) : std::string("nan");
}

/// Length of the sequence and its code point; length 0 if the bytes are not well formed.
struct CodePoint {
  std::size_t length = 0;
  unsigned code = 0;
};

CodePoint decoded(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned>(static_cast<unsigned char>(text[i])); };
  const unsigned first = byte(at);
  if (first < 0x80) return {1, first};
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || at + length > text.size()) return {};
  unsigned code = first & (0xFFu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xC0u) != 0x80u) return {};
    code = code << 6 | (byte(at + i) & 0x3Fu);
  }
  const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  return overlong || surrogate || code > 0x10FFFF ? CodePoint{} : CodePoint{length, code};
}

struct CodeRange {
  unsigned first, last;
};

/// Unicode's Cc, its format characters (Cf) except those of scripts, and the separators of lines.
constexpr CodeRange hidden[]{{0x00, 0x1F},     {0x7F, 0x9F},     {0xAD, 0xAD},      {0x61C, 0x61C},
                             {0x180E, 0x180E}, {0x200B, 0x200F}, {0x2028, 0x202E},  {0x2060, 0x206F},
                             {0xFEFF, 0xFEFF}, {0xFFF9, 0xFFFB}, {0xE0000, 0xE007F}};

/// Decimal exponent of a number other than 0.
int magnitude(double value) { return static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-12)); }

}  // namespace

std::size_t utf8_length(std::string_view text, std::size_t at) { return decoded(text, at).length; }

unsigned code_point(std::string_view text, std::size_t at) { return decoded(text, at).code; }

std::size_t hidden_length(std::string_view text, std::size_t at) {
  const CodePoint c = decoded(text, at);
  if (c.length == 0) return 1;
  const bool is_hidden = std::any_of(std::begin(hidden), std::end(hidden), [&](const CodeRange& r) {
    return r.first <= c.code && c.code <= r.last;
  });
  return is_hidden ? c.length : 0;
}

std::size_t display_width(std::string_view text) {
  std::size_t width = 0;
  for (const char c : text) width += (static_cast<unsigned char>(c) & 0xC0u) != 0x80u;
  return width;
}

std::vector<std::string> wrapped_lines(std::string_view text, std::size_t width, std::size_t first_width,
                                       LongWords long_words) {
  std::vector<std::string> lines{""};
  const auto add = [&](std::string_view word) {
    const std::size_t room = lines.size() == 1 ? first_width : width;
    if (lines.back().empty())
      lines.back() = word;
    else if (display_width(lines.back()) + 1 + display_width(word) <= room)
      lines.back() += ' ' + std::string(word);
    else
      lines.emplace_back(word);
  };
  const std::size_t longest = std::max<std::size_t>(1, std::min(width, first_width));
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = text.find_first_not_of(" \n", at);
    if (begin == std::string_view::npos) break;
    at = std::min(text.find_first_of(" \n", begin), text.size());
    std::string_view word = text.substr(begin, at - begin);
    while (long_words == LongWords::cut && display_width(word) > longest) {
      std::size_t cut = longest;  // bytes, of which there may be more than columns
      while (display_width(word.substr(0, cut + 1)) <= longest) ++cut;
      add(word.substr(0, cut));
      word.remove_prefix(cut);
    }
    add(word);
  }
  return lines;
}

std::string wrapped(std::string_view text, std::size_t width, const std::string& indent,
                    const std::string& first, LongWords long_words) {
  const auto room = [&](const std::string& before) {
    const std::size_t used = display_width(before);
    return width > used ? width - used : 1;
  };
  std::string out;
  for (const std::string& line : wrapped_lines(text, room(indent), room(first), long_words))
    out += (out.empty() ? first : indent) + line + '\n';
  return out;
}

std::string shell_word(const std::string& text) {
  constexpr std::string_view plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-+.,:/@%=_";
  return !text.empty() && text.find_first_not_of(plain) == std::string::npos ? text : shell_quoted(text);
}

std::string shell_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + '\'';
}

std::string quoted(const std::string& text) { return "'" + text + "'"; }

std::string counted(std::size_t count, std::string_view noun) {
  return std::to_string(count) + ' ' + std::string(noun) + (count == 1 ? "" : "s");
}

std::string significant(double value, int digits) {
  return printed(value, std::chars_format::general, digits);
}

std::string fixed_point(double value, int decimals) {
  return printed(value, std::chars_format::fixed, decimals);
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(blanks);
  return begin == std::string_view::npos ? "" : text.substr(begin, text.find_last_not_of(blanks) + 1 - begin);
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

double rounded_to(double value, int digits) {
  const std::string text = printed(value, std::chars_format::scientific, digits - 1);
  double rounded = value;
  std::from_chars(text.data(), text.data() + text.size(), rounded);
  return rounded;
}

std::string hexadecimal(unsigned char byte) {
  constexpr const char* digits = "0123456789ABCDEF";
  return {digits[byte >> 4], digits[byte & 0xF]};
}

PrefixedUnit prefixed(double value, const std::string& unit) {
  // No k1/s, and no k of a pure number, which reads like a unit.
  if (value == 0 || !std::isfinite(value) || unit.empty() || unit.starts_with("1/")) return {1, unit};
  static constexpr std::array<const char*, 8> prefixes{"p", "n", "u", "m", "", "k", "M", "G"};
  // The prefix is that of the rounded value: 999.96 u is 1.00 m.
  const int thousand = std::clamp(static_cast<int>(std::floor(magnitude(rounded_to(value, 3)) / 3.0)), -4, 3);
  return {std::pow(1000.0, thousand), prefixes[thousand + 4] + unit};
}

std::string readable_number(double value) {
  if (std::isnan(value)) return "not known";
  if (std::isinf(value)) return "unbounded";
  if (value == 0) return "0";
  const double rounded = rounded_to(value, 3);
  return std::abs(rounded) >= 1e4 || std::abs(rounded) < 1e-3
             ? printed(rounded, std::chars_format::scientific, 2)
             : fixed_point(rounded, std::max(2 - magnitude(rounded), 0));
}

std::string readable(double value, const std::string& unit) {
  if (!std::isfinite(value)) return readable_number(value);
  const PrefixedUnit prefix = prefixed(value, unit);
  return readable_number(rounded_to(value, 3) / prefix.factor) + (unit.empty() ? "" : ' ' + prefix.unit);
}

}  // namespace qerr
