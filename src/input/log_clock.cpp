#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <string>

#include "input/log_table.hpp"
#include "qerr/core/parameter.hpp"

namespace qerr {

namespace {

constexpr std::int64_t farthest = std::int64_t{1} << 23;  // [s] beyond it a double does not resolve 1 ns
constexpr double atto = 1e18;
constexpr int atto_digits = 18;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The number of a text of digits; empty if it is not one, or has more than 18.
std::optional<std::int64_t> whole(std::string_view digits) {
  std::int64_t number = 0;
  if (digits.empty() || digits.size() > atto_digits || !std::ranges::all_of(digits, is_digit))
    return std::nullopt;
  std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return number;
}

/// Attoseconds of the digits behind the decimal point of seconds; what is smaller is cut off.
std::optional<std::int64_t> attoseconds(std::string decimals) {
  decimals.resize(atto_digits, '0');
  return whole(decimals);
}

/// Decimal digits by which a unit is smaller than the second; empty if it is not a decimal part of it.
std::optional<std::size_t> decimal_shift(const Unit& unit) {
  std::size_t digits = 0;
  double power = 1;
  for (; power < unit.divisor; power *= 10) ++digits;
  if (unit.factor != 1 || power != unit.divisor) return std::nullopt;
  return digits;
}

TimeStamp rounded(double seconds) {
  const double before = std::trunc(seconds);
  return {static_cast<std::int64_t>(before), static_cast<std::int64_t>((seconds - before) * atto)};
}

/// The number in `text`, without rounding if it is written without an exponent, in a decimal part of seconds.
/// @param seconds  the same, rounded
std::optional<TimeStamp> exact(std::string_view text, const Unit& unit, double seconds) {
  if (!(std::abs(seconds) < 0x1p62)) return std::nullopt;
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  const std::size_t point = std::min(text.find('.'), text.size());
  std::string digits(text.substr(0, point)), decimals(text.substr(std::min(point + 1, text.size())));
  const auto shift = decimal_shift(unit);
  if (!shift) return rounded(seconds);
  if (digits.size() <= *shift) digits.insert(0, *shift + 1 - digits.size(), '0');
  decimals.insert(0, digits, digits.size() - *shift);
  digits.resize(digits.size() - *shift);
  const auto s = whole(digits), a = attoseconds(decimals);
  if (!s || !a) return rounded(seconds);
  return negative ? TimeStamp{-*s, -*a} : TimeStamp{*s, *a};
}

/// Takes `count` digits from the front of a text, and the mark behind them.
std::optional<std::int64_t> take(std::string_view& text, std::size_t count, std::string_view marks) {
  const auto number = whole(text.substr(0, count));
  if (!number || text.size() < count || (!marks.empty() && text.size() == count)) return std::nullopt;
  if (!marks.empty() && marks.find(text[count]) == std::string_view::npos) return std::nullopt;
  text.remove_prefix(count + !marks.empty());
  return number;
}

/// Seconds east of Greenwich of the end of a stamp: `Z`, `+02:00`, `+0200`, or nothing, which is taken as
/// UTC.
std::optional<std::int64_t> zone(std::string_view text) {
  if (text.empty() || text == "Z" || text == "z") return 0;
  const bool west = text[0] == '-';
  if (!west && text[0] != '+') return std::nullopt;
  text.remove_prefix(1);
  const bool colon = text.size() == 5;
  const auto hours = take(text, 2, colon ? ":" : ""), minutes = take(text, 2, "");
  if (!hours || !minutes || !text.empty()) return std::nullopt;
  return (west ? -60 : 60) * (60 * *hours + *minutes);
}

/// Takes the digits at the front of a text, at most `most`.
std::optional<std::int64_t> take_digits(std::string_view& text, std::size_t most) {
  std::size_t count = 0;
  while (count < std::min(most, text.size()) && is_digit(text[count])) ++count;
  return take(text, count, "");
}

bool take_mark(std::string_view& text, std::string_view marks) {
  if (text.empty() || marks.find(text.front()) == std::string_view::npos) return false;
  text.remove_prefix(1);
  return true;
}

std::optional<std::int64_t> days_of(std::int64_t year, std::int64_t month, std::int64_t day) {
  const std::chrono::year_month_day date(std::chrono::year(static_cast<int>(year)),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day)));
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch().count();
}

/// `2026-11-26`, `2026/11/26`, `26.11.2026`, `26/11/2026`, `11/26/2026`.
std::optional<CalendarDate> take_date(std::string_view& text) {
  const std::size_t mark = std::min(text.find_first_of("-/."), text.size());
  const bool year_first = mark == 4;
  const auto first = take_digits(text, 4);
  const std::string_view kind = text.substr(0, 1);
  if (!first || !take_mark(text, "-/.")) return std::nullopt;
  const auto second = take_digits(text, 2);
  if (!second || !take_mark(text, kind)) return std::nullopt;
  const auto third = take_digits(text, 4);
  if (!third) return std::nullopt;
  std::int64_t y = *first, m = *second, d = *third;
  if (!year_first) std::swap(y, d);
  if (!year_first && y < 100) y += 2000;
  const bool either = !year_first && kind == "/";
  CalendarDate date{0, either && m != d ? days_of(y, d, m) : std::nullopt, either && m > 12};
  const auto days = date.month_first ? date.exchanged : days_of(y, m, d);
  if (!days) return std::nullopt;
  date.days = *days;
  if (date.month_first || d > 12) date.exchanged.reset();
  return date;
}

/// `hh:mm[:ss[.d...]][ AM| PM]`, or minutes and seconds `mm:ss.d...`; a comma may stand for the point, and
/// behind seconds a colon.
std::optional<TimeStamp> take_time_of_day(std::string_view& text) {
  auto h = take_digits(text, 2);
  if (!h || !take_mark(text, ":")) return std::nullopt;
  auto min = take_digits(text, 2);
  const bool minutes_first = min && !text.empty() && (text.front() == '.' || text.front() == ',');
  const bool with_seconds = min && !minutes_first && take_mark(text, ":");
  auto s = with_seconds ? take_digits(text, 2) : std::optional<std::int64_t>(0);
  if (minutes_first) {
    s = min;
    min = h;
    h = 0;
  }
  if (!min || !s || *h > 24 || *min > 59 || *s > 60) return std::nullopt;
  std::int64_t part = 0;
  if ((with_seconds && take_mark(text, ".,:")) || (minutes_first && take_mark(text, ".,"))) {
    const auto digits = static_cast<std::size_t>(std::ranges::find_if_not(text, is_digit) - text.begin());
    const auto read = digits > 0 ? attoseconds(std::string(text.substr(0, digits))) : std::nullopt;
    if (!read) return std::nullopt;
    part = *read;
    text.remove_prefix(digits);
  }
  std::int64_t hour = *h;
  const std::string_view half = text.starts_with(' ') ? text.substr(1) : text;
  if (half.size() == 2 && (half[1] | 0x20) == 'm' && ((half[0] | 0x20) == 'a' || (half[0] | 0x20) == 'p')) {
    hour = hour % 12 + ((half[0] | 0x20) == 'p' ? 12 : 0);
    text = {};
  }
  return TimeStamp{3600 * hour + 60 * *min + *s, part};
}

/// A date and a time of day, with `T` or a blank between them and perhaps a zone; or a time of day alone.
/// `1 days 00:00:00.25`, as pandas writes a Timedelta, has its days in the time of day.
/// @param date  without it the stamp has the time of day only
std::optional<TimeStamp> calendar_stamp(std::string_view text, std::optional<CalendarDate>& date) {
  if (const std::size_t days = text.find(" day"); days != std::string_view::npos) {
    const auto count = whole(text.substr(0, days));
    const auto time =
        calendar_stamp(text.substr(std::min(text.find(' ', days + 1), text.size() - 1) + 1), date);
    if (!count || !time || date || *count > farthest) return std::nullopt;
    return TimeStamp{86400 * *count + time->seconds, time->attoseconds};
  }
  const std::size_t mark = text.find_first_not_of("0123456789");
  if (mark != std::string_view::npos && text[mark] != ':') {
    date = take_date(text);
    if (!date || !take_mark(text, "Tt ,;_-")) return std::nullopt;
    while (take_mark(text, " ")) {
    }
  }
  const auto time = take_time_of_day(text);
  const auto east = time ? zone(text) : std::nullopt;
  if (!east) return std::nullopt;
  return TimeStamp{time->seconds - *east, time->attoseconds};
}

/// First letters of the months in English, German and French, the longer ones first.
constexpr std::pair<std::string_view, int> months[] = {
    {"juin", 6}, {"juil", 7},     {"jan", 1},  {"feb", 2},  {"f\u00e9v", 2}, {"fev", 2},
    {"mar", 3},  {"m\u00e4r", 3}, {"mrz", 3},  {"apr", 4},  {"avr", 4},      {"may", 5},
    {"mai", 5},  {"jun", 6},      {"jul", 7},  {"aug", 8},  {"ao\u00fb", 8}, {"sep", 9},
    {"oct", 10}, {"okt", 10},     {"nov", 11}, {"dec", 12}, {"dez", 12},     {"d\u00e9c", 12}};

}  // namespace

std::string with_month_number(std::string_view text) {
  const std::size_t begin = std::min(text.find_first_not_of("0123456789 ./-"), text.size());
  const std::size_t end = std::min(text.find_first_of("-./ 0123456789", begin), text.size());
  if (begin == 0 || end - begin < 3) return std::string(text);
  std::string name(text.substr(begin, end - begin));
  for (char& c : name)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 32);
  const char mark = text[begin - 1];
  const std::size_t behind = std::min(text.find_first_not_of(". -/", end), text.size());
  for (const auto& [letters, number] : months)
    if (name.starts_with(letters) && !is_digit(mark) && behind > end)
      return std::string(text.substr(0, text.find_first_of(" .-/"))) + '-' + std::to_string(number) + '-' +
             std::string(text.substr(behind));
  return std::string(text);
}

/// Days since 1970 of a date, by the order of day and month that the log has.
std::int64_t LogClock::days(const CalendarDate& date) {
  const bool open = !month_first_ && last_date_ && last_date_->exchanged;
  if (open) {
    const std::int64_t pause = date.days - last_date_->days;
    const std::int64_t other = date.exchanged.value_or(date.days) - *last_date_->exchanged;
    month_first_ = other >= 0 && (pause < 0 || other < pause);
  }
  month_first_ = month_first_ || date.month_first;
  if (open && month_first_) shift_ = last_date_->days - *last_date_->exchanged;
  last_date_ = date;
  return (month_first_ ? date.exchanged.value_or(date.days) : date.days) + shift_;
}

std::optional<double> LogClock::seconds(std::string_view text, const Unit& unit, WrittenNumbers& written) {
  if (text.empty()) return std::nullopt;
  double number = 0;
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  const bool decimal = read_number(text.data() + plus, number, written) == text.data() + text.size();
  const double rounded_seconds = unit.in_si(number);
  if (decimal && !(std::abs(rounded_seconds) <= physical_range(dimension::time).largest)) return std::nullopt;
  const bool no_epoch = origin_ && origin_->seconds == 0;
  if (decimal && (no_epoch || (!origin_ && std::abs(rounded_seconds) < farthest))) {
    origin_ = TimeStamp{};
    return unit.divisor > 1 ? unwrapped(number, unit) : rounded_seconds;
  }
  const bool in_seconds = unit.factor == 1 && unit.divisor == 1;
  std::optional<CalendarDate> date;
  auto stamp = decimal      ? exact(text, unit, rounded_seconds)
               : in_seconds ? calendar_stamp(with_month_number(text), date)
                            : std::nullopt;
  if (!stamp) return std::nullopt;
  if (date) {
    stamp->seconds += 86400 * days(*date);
  } else if (!decimal) {
    const bool of_hour =
        text.find(':') == text.rfind(':') && text.find_first_of(".,") != std::string_view::npos;
    const std::int64_t period = of_hour ? 3600 : 86400;
    while (last_time_of_day_ && stamp->seconds < *last_time_of_day_ - period / 2) {
      stamp->seconds += period;
      remark_ = of_hour ? "they run over the full hour" : "they run over midnight";
    }
    last_time_of_day_ = stamp->seconds;
  }
  if (!origin_) origin_ = stamp;
  return seconds(*stamp);
}

/// Seconds of a counter of milli-, micro- or nanoseconds, such as micros() of Arduino, that has 32 bits: it
/// falls from close below 2^32 to close above 0.
double LogClock::unwrapped(double number, const Unit& unit) {
  constexpr double turn = 0x1p32, near = 0x1p26;
  if (last_number_ > turn - near && last_number_ < turn && number >= 0 && number < near) {
    ++rollovers_;
    remark_ = "their counter of 32 bits rolls over";
  }
  last_number_ = number;
  return unit.in_si(number + rollovers_ * turn);
}

double LogClock::seconds(const TimeStamp& stamp) {
  if (!origin_) origin_ = std::abs(stamp.seconds) < farthest ? TimeStamp{} : stamp;
  return static_cast<double>(stamp.seconds - origin_->seconds) +
         static_cast<double>(stamp.attoseconds - origin_->attoseconds) / atto;
}

double LogClock::seconds(double stamp) {
  if (!origin_ && std::abs(stamp) < farthest) origin_ = TimeStamp{};
  return origin_ && origin_->seconds == 0 ? stamp : seconds(rounded(stamp));
}

std::string epoch_unit(double stamp) {
  struct Range {
    double least, most;
    const char* unit;
  };
  // Of ticks of 100 ns since 1601 and since the year 1 (Windows, .NET) those from 2001 to 2100; else from
  // 1973, or of nanoseconds 2001, to 5138. The ranges do not overlap.
  constexpr Range ranges[] = {{1.26e17, 1.58e17, "100 ns"},
                              {6.3e17, 6.63e17, "100 ns"},
                              {1e18, 1e20, "ns"},
                              {1e14, 1e17, "us"},
                              {1e11, 1e14, "ms"}};
  for (const Range& r : ranges)
    if (stamp >= r.least && stamp < r.most) return r.unit;
  return {};
}

double LogClock::origin() const {
  return origin_ ? static_cast<double>(origin_->seconds) + static_cast<double>(origin_->attoseconds) / atto
                 : 0;
}

}  // namespace qerr
