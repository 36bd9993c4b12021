#include <algorithm>
#include <array>
#include <cctype>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "core/text.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

/// Edit distance with transpositions (optimal string alignment distance), not case-sensitive.
std::size_t distance(std::string_view a, std::string_view b) {
  const auto same = [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
  };
  std::vector<std::size_t> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    next[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (same(a[i - 1], b[j - 1]) ? 0 : 1)});
      if (i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1]))
        next[j] = std::min(next[j], before[j - 2] + 1);
    }
    before = row;
    row = next;
  }
  return row[b.size()];
}

/// The known names at the smallest distance, if that is one letter or a third of the shorter word at most:
/// `mean` is not near `median`.
std::vector<std::string> all_nearest(std::string_view word, const std::vector<std::string>& known) {
  std::vector<std::string> best;
  if (word.empty() || word.size() > 64) return best;
  std::size_t least = word.size();
  for (const std::string& name : known) {
    const bool begins = word.size() >= 3 && name.starts_with(word);
    const std::size_t d = begins ? std::min<std::size_t>(distance(word, name), 1) : distance(word, name);
    const std::size_t shorter = std::min(word.size(), name.size());
    if (!begins && (d > std::max<std::size_t>(1, shorter / 3) || d >= shorter)) continue;
    if (d > least) continue;
    if (d < least) best.clear();
    least = d;
    best.push_back(name);
  }
  return best;
}

bool digit(char c) { return c >= '0' && c <= '9'; }

std::string without(std::string_view text, std::string_view characters) {
  std::string out;
  for (const char c : text)
    if (characters.find(c) == std::string_view::npos) out += c;
  return out;
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

bool readable_quantity(const std::string& text) {
  std::string why;
  return parse_quantity(text, why).has_value();
}

/// The text of a corrected number, if it is one.
std::optional<NumberAdvice> corrected(std::string rule, std::string text) {
  text.erase(0, text.find_first_not_of(' '));
  if (!readable_quantity(text)) return std::nullopt;
  return NumberAdvice{std::move(rule), "write " + text};
}

/// `0,02 deg`, `1.000,5`, `1,000,000`; of `1,000` both readings are offered.
std::optional<NumberAdvice> comma(std::string_view text) {
  const auto count = std::ranges::count(text, ',');
  if (count == 0) return std::nullopt;
  const std::size_t last = text.rfind(',');
  std::string rule = "a number has a decimal point and no comma";
  if (count > 1) return corrected(std::move(rule), without(text, ","));
  const std::string as_point = replaced(without(text.substr(0, last), "."), ",", "") + '.' +
                               std::string(text.substr(last + 1)),
                    as_group = without(text, ",");
  std::size_t digits = last + 1;
  while (digits < text.size() && digit(text[digits])) ++digits;
  const bool group = digits - last == 4 && last > 0 && text[0] != '0';
  if (group && readable_quantity(as_group) && readable_quantity(as_point))
    return NumberAdvice{std::move(rule), "write " + as_group + " or " + as_point};
  if (text.find('.') < last) return corrected(std::move(rule), as_point);
  if (text.find('.') != std::string_view::npos) return corrected(std::move(rule), as_group);
  return corrected(std::move(rule), as_point);
}

/// `1 000`, `1_000`, `1'000`.
std::optional<NumberAdvice> grouped(std::string_view text) {
  std::string out;
  bool any = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool between = i > 0 && i + 1 < text.size() && digit(text[i - 1]) && digit(text[i + 1]);
    if (between && (text[i] == ' ' || text[i] == '_' || text[i] == '\''))
      any = true;
    else
      out += text[i];
  }
  return any ? corrected("the digits of a number are not separated", out) : std::nullopt;
}

/// Characters of word processors and data sheets that look like ASCII ones.
std::optional<NumberAdvice> lookalikes(std::string_view text) {
  struct Lookalike {
    std::string_view found, rule, instead;
  };
  static constexpr std::array list{
      Lookalike{"\u2212", "the minus sign must be the plain '-'", "-"},
      Lookalike{"\u2013", "the minus sign must be the plain '-', not a dash", "-"},
      Lookalike{"\u00A0", "a non-breaking space is not a space", " "},
      Lookalike{"\u202F", "a narrow space is not a space", " "},
      Lookalike{"\u2009", "a thin space is not a space", " "},
      Lookalike{"\u00B2", "a power of a unit is written with ^", "^2"},
      Lookalike{"\u00B7", "a product of units is written with a space", " "},
      Lookalike{"\u2033", "the sign of an angle is not a unit here", " arcsec"},
      Lookalike{"\u2032", "the sign of an angle is not a unit here", " arcmin"},
      Lookalike{"''", "the sign of an angle is not a unit here", " arcsec"},
      Lookalike{"\"", "the sign of an angle is not a unit here", " arcsec"},
      Lookalike{"'", "the sign of an angle is not a unit here", " arcmin"},
      Lookalike{":", "a ratio is written as a fraction", "/"},
      Lookalike{"**", "a power is written with ^", "^"},
      Lookalike{"\u00B1", "a number has one sign", ""},
      Lookalike{"+/-", "a number has one sign", ""},
      Lookalike{"+-", "a number has one sign", ""},
      Lookalike{"~", "a number has no sign of approximation", ""},
      Lookalike{"\u2248", "a number has no sign of approximation", ""},
      Lookalike{"<", "a number has no sign of comparison", ""},
      Lookalike{"\u2264", "a number has no sign of comparison", ""},
  };
  for (const Lookalike& l : list)
    if (text.find(l.found) != std::string_view::npos)
      if (auto advice = corrected(std::string(l.rule), replaced(std::string(text), l.found, l.instead)))
        return advice;
  return std::nullopt;
}

/// The symbol of a unit that is written out or in other letters; "" if there is none.
std::string known_symbol(std::string_view word) {
  static const std::vector<std::pair<std::string_view, std::string_view>> names{{"degree", "deg"},
                                                                                {"degrees", "deg"},
                                                                                {"radian", "rad"},
                                                                                {"radians", "rad"},
                                                                                {"arcminute", "arcmin"},
                                                                                {"arcminutes", "arcmin"},
                                                                                {"arcsecond", "arcsec"},
                                                                                {"arcseconds", "arcsec"},
                                                                                {"arc-sec", "arcsec"},
                                                                                {"as", "arcsec"},
                                                                                {"sec", "s"},
                                                                                {"secs", "s"},
                                                                                {"second", "s"},
                                                                                {"seconds", "s"},
                                                                                {"msec", "ms"},
                                                                                {"usec", "us"},
                                                                                {"minutes", "min"},
                                                                                {"hour", "h"},
                                                                                {"hours", "h"},
                                                                                {"hertz", "Hz"},
                                                                                {"meter", "m"},
                                                                                {"meters", "m"},
                                                                                {"metre", "m"},
                                                                                {"metres", "m"},
                                                                                {"millimeter", "mm"},
                                                                                {"millimeters", "mm"},
                                                                                {"millimetre", "mm"},
                                                                                {"millimetres", "mm"},
                                                                                {"micron", "um"},
                                                                                {"microns", "um"},
                                                                                {"micrometer", "um"},
                                                                                {"micrometers", "um"},
                                                                                {"\u00B5", "um"},
                                                                                {"\u03BC", "um"},
                                                                                {"inch", "in"},
                                                                                {"inches", "in"},
                                                                                {"percent", "%"},
                                                                                {"turn", "rev"},
                                                                                {"turns", "rev"},
                                                                                {"revolution", "rev"},
                                                                                {"revolutions", "rev"},
                                                                                {"deg/sec", "deg/s"},
                                                                                {"dps", "deg/s"},
                                                                                {"hz", "Hz"},
                                                                                {"khz", "kHz"},
                                                                                {"KHz", "kHz"},
                                                                                {"KHZ", "kHz"},
                                                                                {"mhz", "MHz"},
                                                                                {"Mhz", "MHz"},
                                                                                {"HZ", "Hz"},
                                                                                {"RPM", "rpm"},
                                                                                {"U/min", "rpm"},
                                                                                {"r/min", "rpm"},
                                                                                {"1/min", "rpm"},
                                                                                {"celsius", "degC"},
                                                                                {"\u00B0C", "degC"},
                                                                                {"MM", "mm"},
                                                                                {"Mm", "mm"},
                                                                                {"UM", "um"},
                                                                                {"Deg", "deg"},
                                                                                {"DEG", "deg"},
                                                                                {"Rad", "rad"},
                                                                                {"RAD", "rad"},
                                                                                {"mRad", "mrad"},
                                                                                {"S", "s"},
                                                                                {"newton", "N"}};
  for (const auto& [name, symbol] : names)
    if (word == name) return std::string(symbol);
  std::string ignored;
  return parse_unit(word, ignored) ? std::string(word) : "";
}

/// The symbol that is meant, or nearly written; "" if no unit is near. A unit in front of which a letter
/// stands is none: that may be a prefix, such as the G of GHz.
std::string unit_symbol(std::string_view word) {
  if (std::string known = known_symbol(word); !known.empty()) return known;
  if (const std::size_t slash = word.find('/'); slash != std::string_view::npos) {
    const std::string above = unit_symbol(word.substr(0, slash)),
                      below = known_symbol(word.substr(slash + 1));
    if (!above.empty() && !below.empty()) return above + '/' + below;
  }
  if (word.size() > 1 && !known_symbol(word.substr(1)).empty()) return "";
  return nearest(word,
                 {"deg", "rad", "mrad", "urad", "arcmin", "arcsec", "rev",  "rpm",     "Hz",     "kHz", "MHz",
                  "mm",  "um",  "ms",   "us",   "rad/s",  "deg/s",  "mm/s", "rad/s^2", "counts", "bits"});
}

/// A number whose unit is unknown.
std::optional<NumberAdvice> unknown_unit(std::string_view text, const std::string& why) {
  if (!why.starts_with("unknown unit '")) return std::nullopt;
  const std::size_t at = text.find_first_not_of("+-0123456789.eE/ ");
  if (at == std::string_view::npos) return std::nullopt;
  const std::string number(text.substr(0, text.find_last_not_of(' ', at - (at > 0)) + (at > 0)));
  const std::string unit(text.substr(at));
  if (unit == "k" || unit == "K") return corrected(why, number + "e3");
  if (unit == "x" || unit == "X" || unit == "\u00D7") return NumberAdvice{why, "write " + number};
  const std::string symbol = unit_symbol(unit);
  const std::string whole = number + ' ' + symbol;
  if (symbol.empty() || !readable_quantity(whole)) return std::nullopt;
  return NumberAdvice{why, "write " + whole};
}

/// `pi^2`, `90*3.14/180`, `${x}`, `1e3*2`.
bool is_expression(std::string_view text) {
  return text.find("pi") != std::string_view::npos || text.find('*') != std::string_view::npos ||
         text.find(" x ") != std::string_view::npos ||
         text.find('^') < text.find_first_of("abcdefghijklmnopqrstuvwxyz") ||
         text.find("${") != std::string_view::npos || text.find("sqrt") != std::string_view::npos;
}

}  // namespace

std::string nearest(std::string_view word, const std::vector<std::string>& known) {
  const std::vector<std::string> best = all_nearest(word, known);
  return best.empty() ? "" : best.front();
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& known) {
  constexpr std::size_t most_suggestions = 2;
  const std::vector<std::string> near = all_nearest(word, known);
  if (!near.empty() && near.size() <= most_suggestions)
    return "did you mean '" + near.front() + "'" + (near.size() > 1 ? " or '" + near.back() + "'" : "") + "?";
  std::string text = "known: ";
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (i == 12) return text + ", ...";
    text += (i ? ", " : "") + known[i];
  }
  return known.empty() ? "no name is allowed here" : text;
}

NumberAdvice advice_on_number(std::string_view text, const std::string& why) {
  if (text.find_first_not_of(' ') == std::string_view::npos) return {"a number is missing", ""};
  if (auto advice = comma(text)) return *advice;
  if (auto advice = grouped(text)) return *advice;
  if (auto advice = lookalikes(text)) return *advice;
  if (auto advice = unknown_unit(text, why)) return *advice;
  if (is_expression(text)) return {"an expression is not evaluated", "write its value"};
  std::string ignored;
  if (!digit(text.front()) && parse_unit(text, ignored)) return {"the number before the unit is missing", ""};
  if (text.find_first_of("0123456789") == std::string_view::npos &&
      text.find("inf") == std::string_view::npos && text.find("nan") == std::string_view::npos)
    return {"must be a number", ""};
  if (text.starts_with("0x") || text.starts_with("0X")) return {"a number must be decimal", ""};
  if (text.size() > 1 && text[0] == '0' && digit(text[1])) {
    const std::string plain(text.substr(std::min(text.find_first_not_of('0'), text.size() - 1)));
    if (auto advice = corrected("a leading zero is ambiguous: it may mean an octal number", plain))
      return *advice;
  }
  return {why, ""};
}

}  // namespace qerr
