#include "qerr/core/quantity.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "core/text.hpp"

namespace qerr {

namespace {

Dimension power(Dimension d, int n) {
  return {d.metre * n, d.radian * n, d.second * n, d.newton * n, d.kelvin * n};
}

Dimension product(Dimension a, Dimension b) {
  return {a.metre + b.metre, a.radian + b.radian, a.second + b.second, a.newton + b.newton,
          a.kelvin + b.kelvin};
}

using std::numbers::pi;

constexpr std::array symbols{
    UnitSymbol{"m", 1, dimension::length, true},
    UnitSymbol{"in", 0.0254, dimension::length},
    UnitSymbol{"rad", 1, dimension::angle, true},
    UnitSymbol{"deg", pi / 180, dimension::angle, true},
    UnitSymbol{"°", pi / 180, dimension::angle},
    UnitSymbol{"º", pi / 180, dimension::angle},  // U+00BA, the key next to 0 on many keyboards
    UnitSymbol{"arcmin", pi / 10800, dimension::angle},
    UnitSymbol{"arcsec", pi / 648000, dimension::angle},
    UnitSymbol{"gon", pi / 200, dimension::angle, true},
    UnitSymbol{"rev", 2 * pi, dimension::angle, true},
    UnitSymbol{"s", 1, dimension::time, true},
    UnitSymbol{"min", 60, dimension::time},
    UnitSymbol{"h", 3600, dimension::time},
    UnitSymbol{"d", 86400, dimension::time},
    UnitSymbol{"Hz", 1, dimension::frequency, true},
    UnitSymbol{"rpm", 2 * pi / 60, dimension::angular_speed},
    UnitSymbol{"N", 1, {0, 0, 0, 1}, true},
    UnitSymbol{"Nm", 1, dimension::torque, true},
    UnitSymbol{"g", 1e-3, {-1, 0, 2, 1}, true},
    UnitSymbol{"K", 1, dimension::temperature},
    UnitSymbol{"degC", 1, dimension::temperature},
    UnitSymbol{"%", 0.01, dimension::none},
    UnitSymbol{"ppm", 1e-6, dimension::none},
    UnitSymbol{"count", 1, dimension::none},
    UnitSymbol{"counts", 1, dimension::none},
    UnitSymbol{"bit", 1, dimension::none},
    UnitSymbol{"bits", 1, dimension::none},
    UnitSymbol{"1", 1, dimension::none},
};

constexpr std::array prefixes{UnitPrefix{"n", 1, 1e9}, UnitPrefix{"u", 1, 1e6}, UnitPrefix{"µ", 1, 1e6},
                              UnitPrefix{"μ", 1, 1e6}, UnitPrefix{"m", 1, 1e3}, UnitPrefix{"c", 1, 1e2},
                              UnitPrefix{"k", 1e3},    UnitPrefix{"M", 1e6}};

std::optional<Unit> find_symbol(std::string_view word) {
  for (const UnitSymbol& s : symbols)
    if (word == s.name) return Unit{s.factor, 1, s.dimension};
  for (const UnitPrefix& p : prefixes)
    for (const UnitSymbol& s : symbols)
      if (s.prefixable && word.size() == p.name.size() + s.name.size() && word.starts_with(p.name) &&
          word.ends_with(s.name))
        return Unit{p.factor * s.factor, p.divisor, s.dimension};
  return std::nullopt;
}

/// Grammar: unit = factor {(' ' | '*' | '/') factor}; factor = (SYMBOL | '(' unit ')') ['^' digit].
class UnitReader {
 public:
  UnitReader(std::string_view text, std::string& why) : text_(text), why_(why) {}

  std::optional<Unit> whole() {
    auto unit = sequence(0);
    if (unit && at_ != text_.size())
      return fail("the unit has unexpected text '" + std::string(text_.substr(at_)) + "'");
    return unit;
  }

 private:
  std::optional<Unit> fail(std::string why) {
    if (why_.empty()) why_ = std::move(why);
    return std::nullopt;
  }

  void skip_blanks() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }

  std::optional<Unit> sequence(int depth) {
    auto unit = factor(depth);
    while (unit) {
      skip_blanks();
      if (at_ == text_.size() || text_[at_] == ')') return unit;
      const bool divides = text_[at_] == '/';
      if (divides || text_[at_] == '*') ++at_;
      skip_blanks();
      const auto next = factor(depth);
      if (!next) return std::nullopt;
      unit = Unit{unit->factor * (divides ? next->divisor : next->factor),
                  unit->divisor * (divides ? next->factor : next->divisor),
                  product(unit->dimension, power(next->dimension, divides ? -1 : 1))};
    }
    return unit;
  }

  std::optional<Unit> factor(int depth) {
    std::optional<Unit> unit;
    if (at_ < text_.size() && text_[at_] == '(') {
      if (depth > 3) return fail("the unit has too many nested brackets");
      ++at_;
      unit = sequence(depth + 1);
      if (unit && (at_ == text_.size() || text_[at_] != ')'))
        return fail("a bracket in the unit is not closed");
      ++at_;
    } else {
      const std::size_t end = std::min(text_.find_first_of(" */()^", at_), text_.size());
      const std::string_view word = text_.substr(at_, end - at_);
      unit = find_symbol(word);
      if (!unit) return fail("unknown unit '" + std::string(word) + "'");
      at_ = end;
    }
    if (unit && at_ < text_.size() && text_[at_] == '^') {
      ++at_;
      if (at_ == text_.size() || text_[at_] < '1' || text_[at_] > '9')
        return fail("the exponent of a unit must be 1 to 9");
      const int n = text_[at_++] - '0';
      unit = Unit{std::pow(unit->factor, n), std::pow(unit->divisor, n), power(unit->dimension, n)};
    }
    return unit;
  }

  std::string_view text_;
  std::string& why_;
  std::size_t at_ = 0;
};

std::string base_units(Dimension d, int sign) {
  std::string text;
  const auto add = [&](std::string_view name, int exponent) {
    if (exponent * sign <= 0) return;
    text += (text.empty() ? "" : " ") + std::string(name);
    if (exponent * sign > 1) text += '^' + std::to_string(exponent * sign);
  };
  add("rad", d.radian);
  add("N", d.newton);
  add("m", d.metre);
  add("s", d.second);
  add("K", d.kelvin);
  return text;
}

/// The end of the number that begins at `at`: digits, points, signs and exponents. An 'e' belongs to it only
/// before a digit or sign.
std::size_t end_of_number(std::string_view text, std::size_t at) {
  std::size_t end = at;
  while (end < text.size()) {
    const char c = text[end];
    const bool exponent = (c == 'e' || c == 'E') && end + 1 < text.size() &&
                          (std::string_view("0123456789+-").find(text[end + 1]) != std::string_view::npos);
    const bool sign_after_exponent =
        (c == '+' || c == '-') && (end == at || text[end - 1] == 'e' || text[end - 1] == 'E');
    if (!((c >= '0' && c <= '9') || c == '.' || exponent || sign_after_exponent)) break;
    ++end;
  }
  return end;
}

std::size_t after_blanks(std::string_view text, std::size_t at) {
  while (at < text.size() && text[at] == ' ') ++at;
  return at;
}

/// The end of `pi` at or behind `at`, as in `3*pi/4`; empty if it does not stand there.
std::optional<std::size_t> end_of_pi(std::string_view text, std::size_t at, bool behind_number) {
  at = after_blanks(text, at);
  if (behind_number && at < text.size() && text[at] == '*') at = after_blanks(text, at + 1);
  const std::size_t end = at + 2;
  if (text.substr(at, 2) != "pi" || (end < text.size() && text[end] != ' ' && text[end] != '/'))
    return std::nullopt;
  return end;
}

/// The number or fraction at the start of the text, such as `0.5`, `1/100` or `-pi/2`. @returns it and its
/// end
std::optional<std::pair<double, std::size_t>> leading_number(std::string_view text) {
  const std::size_t sign = text.starts_with('-') || text.starts_with('+') ? 1 : 0;
  std::size_t end = end_of_number(text, 0);
  std::optional<double> number = parse_number(text.substr(0, end));
  if (end == sign && end_of_pi(text, sign, false)) number = text.starts_with('-') ? -1 : 1;
  if (!number) return std::nullopt;
  if (const auto after = end_of_pi(text, end, end > sign)) {
    *number *= pi;
    end = *after;
  }
  const std::size_t slash = after_blanks(text, end);
  if (slash == text.size() || text[slash] != '/') return std::pair(*number, end);
  const std::size_t below = after_blanks(text, slash + 1);
  end = end_of_number(text, below);
  if (end == below) return std::pair(*number, slash);  // no digit: the unit begins with the slash
  const auto divisor = parse_number(text.substr(below, end - below));
  if (!divisor || *divisor == 0) return std::nullopt;
  const double quotient = *number / *divisor;
  if (!std::isfinite(quotient) || (quotient == 0) != (*number == 0)) return std::nullopt;
  return std::pair(quotient, end);
}

}  // namespace

std::string unit_name(const Dimension& d) {
  if (d == dimension::frequency) return "Hz";
  const std::string above = base_units(d, 1);
  const std::string below = base_units(d, -1);
  if (below.empty()) return above;
  const bool brackets = below.find(' ') != std::string::npos;
  return (above.empty() ? "1" : above) + '/' + (brackets ? '(' + below + ')' : below);
}

std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const std::size_t digits = text.starts_with('-') ? 1 : 0;
  // from_chars also accepts inf, nan and "-+1"; other YAML parsers read leading zeros as octal.
  if (text.size() <= digits || !((text[digits] >= '0' && text[digits] <= '9') || text[digits] == '.'))
    return std::nullopt;
  if (text[digits] == '0' && text.size() > digits + 1 && text[digits + 1] >= '0' && text[digits + 1] <= '9')
    return std::nullopt;
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

std::optional<Quantity> parse_quantity(std::string_view text, std::string& why) {
  why.clear();
  const auto number = leading_number(text);
  if (!number) {
    why = "not a finite decimal number";
    return std::nullopt;
  }
  const std::size_t end = after_blanks(text, number->second);
  const auto unit = end == text.size() ? std::optional(Unit{}) : UnitReader(text.substr(end), why).whole();
  if (!unit) return std::nullopt;
  const double value = unit->in_si(number->first);
  if (!std::isfinite(value) || (value == 0 && number->first != 0)) {
    why = "not a finite decimal number";
    return std::nullopt;
  }
  return Quantity{value, end == text.size() ? std::nullopt : std::optional(unit->dimension)};
}

std::span<const UnitSymbol> unit_symbols() { return symbols; }

std::span<const UnitPrefix> unit_prefixes() { return prefixes; }

std::optional<Unit> parse_unit(std::string_view text, std::string& why) {
  why.clear();
  const auto size = leading_number(text);
  if (!size || size->first == 0 || size->second == text.size() || text[size->second] != ' ')
    return UnitReader(text, why).whole();
  auto unit = UnitReader(text.substr(after_blanks(text, size->second)), why).whole();
  if (!unit) return std::nullopt;
  const bool divides = size->first > 1 && std::fmod(unit->divisor, size->first) == 0;
  if (divides)
    unit->divisor /= size->first;  // integers stay integers: 100 ns are 1e-7 s
  else
    unit->factor *= size->first;
  return unit;
}

std::string shortest(double value) {
  char buffer[40];
  const auto [end, failure] = std::to_chars(buffer, buffer + sizeof buffer, value);
  return failure == std::errc{} ? std::string(buffer, end) : std::string("nan");
}

}  // namespace qerr
