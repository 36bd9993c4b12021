#include "input/log_names.hpp"

#include <algorithm>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/log_columns.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 32);
  return lower;
}

/// Words for a unit in headers of English, German and French logs, in lower case.
struct UnitWords {
  std::string_view unit, words;
};
constexpr UnitWords unit_words[]{
    {"deg", " degree degrees degs grados gradi "},
    {"rad", " radian radians "},
    {"in", " inch inches zoll "},
    {"arcsec", " arcseconds arcsecond arc-seconds \" "},
    {"arcmin", " arcminutes arcminute ' "},
    {"rev",
     " revolution revolutions revs turn turns cycles umdrehungen umdrehung tr tours tour vueltas giri "},
    {"s", " sec secs second seconds sekunde sekunden seconde secondes segundo segundos secondo secondi "},
    {"ms",
     " msec msecs millis millisec millisecond milliseconds millisekunden millisecondes milisegundos "
     "millisecondi "},
    {"us", " usec usecs \u00b5sec micros microsec microsecond microseconds mikrosekunden microsecondes "},
    {"ns", " nsec nsecs nanos nanosec nanosecond nanoseconds nanosekunden nanosecondes "},
    {"min", " minute minutes minuten "},
    {"h", " hour hours stunden heures "},
    {"m", " meter meters metre metres "},
    {"mm", " millimeter millimeters millimetre millimetres "},
    {"um", " micron microns micrometer micrometers micrometre micrometres "},
    {"count",
     " tick ticks pulse pulses cts cnt cnts inc incs increment increments lsb qc inkr ink inkremente "
     "inkrement impulse impulsions imp points pts cuentas pulsos conteggi impulsi "},
    {"A", " amp amps ampere amperes "},
    {"mA", " milliamp milliamps "},
    {"N m", " nm n\u00b7m n*m n-m n.m n\u22c5m newton-meter newton-meters newtonmeter "},
    {"degC", " \u00b0c celsius "},
    {"rpm", " u/min tr/min 1/min r/min rev/min min-1 min^-1 "},
};

/// Names of the time stamps, in lower case, with one underscore for whatever is between their words.
constexpr std::string_view time_names =
    " time timestamp time_stamp stamp t datetime date_time date_and_time zeit zeitstempel zeitpunkt uhrzeit "
    "datum_zeit datum_uhrzeit datum_und_uhrzeit messzeit laufzeit temps heure date_heure horodatage horodate "
    "tiempo tempo segundos secondi sec msec usec elapsed elapsed_time rel_time relative_time sim_time epoch "
    "unix_time unixtime local_time systime "
    "sys_time "
    "robot_time datenum seconds secs sekunden secondes millis micros milliseconds microseconds nanoseconds "
    "header_stamp "
    "receive_time recv_time log_time x_value ";
/// Names that mean them where no other column does: `Date` stands beside `Time`, and `ts` may be a step.
constexpr std::string_view lesser_time_names = " date datum ts uptime duration dauer clock ";

bool is_one_of(std::string_view names, std::string_view name) {
  std::string words;
  for (const char c : lower_case(trimmed(name))) {
    const auto u = static_cast<unsigned char>(c);
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || u >= 0x80)
      words += c;
    else if (!words.empty() && words.back() != '_')
      words += '_';
  }
  if (words.ends_with('_')) words.pop_back();
  return !words.empty() && names.find(' ' + words + ' ') != std::string_view::npos;
}

/// `time_ms` in `ms`: the unit behind the last underscore. A letter alone is the start of a word more often,
/// as in `theta_m`, except behind a time.
ColumnName by_underscore(const std::string& text) {
  const std::size_t at = text.rfind('_');
  if (at == std::string::npos || at == 0) return {text, {}};
  const std::string name = text.substr(0, at), word = text.substr(at + 1);
  const std::string unit = unit_in_words(word);
  const bool letter = word.size() == 1 && !(word == "s" && is_time_name(name));
  // `encoder_counts` is a name.
  if (unit.empty() || unit == "count" || unit == "counts" || unit == "A" || letter) return {text, {}};
  return {name, unit};
}

/// `ref mrad`, `ref/turns`, `Time ms`: the last word, if it is a unit and no other word.
std::optional<ColumnName> by_last_word(const std::string& text) {
  const std::size_t at = text.find_last_of(" /");
  if (at == std::string::npos || at == 0 || text.size() - at < 3) return std::nullopt;
  const std::string unit = unit_in_words(text.substr(at + 1));
  std::string why;
  const auto read = parse_unit(unit, why);
  if (!read || read->dimension == dimension::none || unit == "in" || unit == "min") return std::nullopt;
  return ColumnName{std::string(bare_cell(text.substr(0, at))), unit};
}

/// `NAME (UNIT)` or `NAME [UNIT]`.
std::optional<ColumnName> in_brackets(const std::string& text) {
  if (text.empty() || (text.back() != ')' && text.back() != ']')) return std::nullopt;
  const std::size_t open = text.rfind(text.back() == ')' ? '(' : '[');
  if (open == std::string::npos || open == 0) return std::nullopt;
  const std::string inside(bare_cell(text.substr(open + 1, text.size() - open - 2)));
  const std::string unit = unit_in_words(inside);
  const std::string name(bare_cell(text.substr(0, open)));
  // In parentheses, or with a number in brackets (`position[0]`), it may be a part of the name.
  if (unit.empty() || (inside == "1" && text[open - 1] != ' ')) return std::nullopt;
  return ColumnName{name, unit};
}

/// Whether a mapping names a column, by its text in the header, by its name without a unit, or, where no
/// header is so called, by its number: `column 3`.
bool names_column(const std::string& wanted, const std::vector<std::string>& header, std::size_t i) {
  if (wanted == header[i]) return true;
  if (contains(header, wanted)) return false;
  return wanted == column_name(header[i]).name || wanted == measured_name(header[i]).name ||
         wanted == "column " + std::to_string(i + 1);
}

/// A mapping to `NAME [UNIT]`, where no column is so called: to NAME, in this unit.
LogSource with_own_unit(const LogSource& source, const std::vector<std::string>& header) {
  for (std::size_t i = 0; i < header.size(); ++i)
    if (names_column(source.column, header, i)) return source;
  const ColumnName parts = column_name(source.column);
  if (parts.unit.empty()) return source;
  return {source.signal, parts.name, source.unit.empty() ? parts.unit : source.unit};
}

}  // namespace

std::string unit_in_words(std::string_view word) {
  if (word == "\u00b0" || word == "\u00ba" || word == "Grad") return "deg";
  if (word == "A" || word == "mA") return std::string(word);
  if (word.ends_with('.')) word.remove_suffix(1);  // `sec.`
  const std::string lower = lower_case(word);
  if (lower.empty()) return "";
  std::string why;
  if (word != "Nm" && parse_unit(word, why)) return std::string(word);
  for (const UnitWords& row : unit_words)
    if (lower.find(' ') == std::string::npos && row.words.find(' ' + lower + ' ') != std::string_view::npos)
      return std::string(row.unit);
  std::size_t slash = lower.find('/'), behind = slash + 1;
  if (const std::size_t per = lower.find(" per "); slash == std::string::npos && per != std::string::npos)
    slash = per, behind = per + 5;
  if (slash == std::string::npos) return "";
  const std::string above = unit_in_words(word.substr(0, slash)), below = unit_in_words(word.substr(behind));
  return above.empty() || below.empty() ? "" : above + '/' + below;
}

ColumnName measured_name(const std::string& cell) {
  const ColumnName exact = column_name(cell);
  if (!exact.unit.empty()) {
    const std::string unit = unit_in_words(exact.unit);
    // `q[1]` is the second of a list, `a1.effort [1]` an effort in an arbitrary unit.
    const bool digits =
        std::all_of(exact.unit.begin(), exact.unit.end(), [](char c) { return c >= '0' && c <= '9'; });
    const bool effort = exact.unit == "1" && exact.name.ends_with(".effort") && exact.name.size() > 7;
    if (digits && !effort && cell.size() == exact.name.size() + exact.unit.size() + 2) return {cell, {}};
    return {exact.name, unit.empty() ? exact.unit : unit};
  }
  const std::string& text = exact.name;
  if (auto parts = in_brackets(text)) return *parts;
  for (const std::string_view mark : {" / ", ", ", " in ", " en "})
    if (const std::size_t at = text.rfind(mark); at != std::string::npos && at > 0)
      if (const std::string unit = unit_in_words(bare_cell(text.substr(at + mark.size()))); !unit.empty())
        return {std::string(bare_cell(text.substr(0, at))), unit};
  if (auto parts = by_last_word(text)) return *parts;
  return by_underscore(text);
}

bool is_time_name(std::string_view name) { return is_one_of(time_names, name); }

std::vector<ColumnMeaning> column_meanings(const std::vector<std::string>& header,
                                           const LogReading& reading) {
  std::vector<ColumnMeaning> all;
  std::vector<LogSource> sources;  // of columns that have one name the first
  std::vector<bool> found(reading.columns.size(), false);
  for (const LogSource& source : reading.columns) sources.push_back(with_own_unit(source, header));
  for (std::size_t i = 0; i < header.size(); ++i) {
    const ColumnName parts = measured_name(header[i]);
    ColumnMeaning meaning{parts.name, parts.unit, false};
    for (std::size_t k = 0; k < sources.size() && !meaning.mapped; ++k) {
      if (found[k] || !names_column(sources[k].column, header, i)) continue;
      meaning = {sources[k].signal, sources[k].unit.empty() ? parts.unit : sources[k].unit, true};
      found[k] = true;
    }
    const bool elsewhere =
        !meaning.mapped && std::any_of(sources.begin(), sources.end(),
                                       [&](const LogSource& s) { return s.signal == parts.name; });
    if (elsewhere && parts.name != "time") meaning = {header[i], {}, false};
    all.push_back(std::move(meaning));
  }
  return all;
}

std::optional<std::size_t> time_column(const std::vector<ColumnMeaning>& columns) {
  std::optional<std::size_t> named, alike, less_alike;
  std::size_t similar = 0, less_similar = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const ColumnMeaning& c = columns[i];
    if (c.signal == "time" && c.mapped) return i;
    if (c.signal == "time" && !named) named = i;
    if (!c.mapped && is_time_name(c.signal) && similar++ == 0) alike = i;
    if (!c.mapped && is_one_of(lesser_time_names, c.signal) && less_similar++ == 0) less_alike = i;
  }
  if (named) return named;
  if (similar > 0) return similar == 1 ? alike : std::nullopt;
  return less_similar == 1 ? less_alike : std::nullopt;
}

std::string program_time_unit(const std::vector<std::string>& header) {
  const bool libfranka = std::any_of(header.begin(), header.end(), [](const std::string& cell) {
    return cell == "success rate" || cell == "success_rate";
  });
  return libfranka ? "ms" : "";
}

void map_column(const std::string& assignment, Spec& spec) {
  const std::size_t mark = assignment.find('=');
  if (mark == std::string::npos || mark == 0 || mark + 1 == assignment.size())
    throw Error({"--column", 0, 0}, "", "not a signal and its column", quoted(assignment),
                "such as --column a1.counts=q1_motor, or --column 'a1.reference=q1_link [deg]'",
                Trouble::usage);
  const std::string signal = assignment.substr(0, mark);
  try {
    require_log_signal(signal, {"--column", 0, 0}, "", spec.model.chain);
  } catch (const Error& e) {
    throw Error(e.faults(), Trouble::usage);
  }
  std::erase_if(spec.log.columns, [&](const LogSource& s) { return s.signal == signal; });
  spec.log.columns.push_back({signal, assignment.substr(mark + 1), {}});
}

}  // namespace qerr
