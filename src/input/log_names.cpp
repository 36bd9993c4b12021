#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/csv.hpp"
#include "input/log_table.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

/// Words for a unit in headers of English, German and French logs, in lower case.
struct UnitWords {
  std::string_view unit, words;
};
constexpr UnitWords unit_words[]{
    {"deg", " deg degree degrees degs grados gradi "},
    {"rad", " rad radian radians "},
    {"mrad", " mrad milliradian milliradians "},
    {"in", " inch inches zoll "},
    {"arcsec", " arcseconds arcsecond arc-seconds \" "},
    {"arcmin", " arcminutes arcminute ' "},
    {"rev",
     " revolution revolutions revs turn turns cycles umdrehungen umdrehung tr tours tour vueltas giri "},
    {"s", " sec sek secs second seconds sekunde sekunden seconde secondes segundo segundos secondo secondi "},
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
  if (inside == "-") return ColumnName{name, {}};  // none
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

/// `MS`, `GON`, `S` in brackets, where only a unit of time, angle or length can be meant; a turn is German
/// `U`.
std::string unit_in_capitals(const std::string& unit) {
  if (unit == "U") return "rev";
  const std::string lower = lower_case(unit);
  std::string why;
  const auto read = parse_unit(lower, why);
  const bool alone = lower.size() == 1 && lower != "s";
  return read && !alone &&
                 (read->dimension == dimension::time || read->dimension == dimension::angle ||
                  read->dimension == dimension::length)
             ? lower
             : "";
}

/// Words of headers in English, German and French that say what a column is. The first row that has a word of
/// the name decides: `target_position` is a command, `motor_current` an effort.
struct RoleWords {
  ColumnRole role;
  std::string_view words;
};
constexpr RoleWords role_words[]{
    // Derivatives and flags that no signal of a log is; `d` is the index of desired values of libfranka.
    {ColumnRole::other,
     " qdd ddq acceleration accel acc beschleunigung jerk voltage pwm power mode fault status error "
     "err i2t digital ratio index valid seq quality deviation abweichung ecart \u00e9cart delta diff "
     "difference residual fehler erreur "},
    {ColumnRole::command,
     " ip target command commanded cmd desired demand setpoint soll sollwert sollposition goal "
     "consigne consigna d des reference_position "},
    {ColumnRole::velocity,
     " velocity vel speed qd dq qdot omega geschwindigkeit drehzahl vitesse velocidad velocit\u00e0 rpm "},
    {ColumnRole::effort,
     " mt effort torque tau current moment drehmoment strom couple courant corriente corrente coppia force "
     "kraft load_torque "},
    {ColumnRole::temperature, " temperature temperatures temp temperatur "},
    {ColumnRole::tip, " tcp tip ee endeffector effector transform pose tracker marker "},
    {ColumnRole::counts,
     " counts count ticks tick raw pulses increments inkremente impulse cnt cnts cts imp steps encodercounts "
     "compteur z\u00e4hler zaehler impulsions cuentas pulsos conteggi impulsi "},
    {ColumnRole::position,
     " mp jpos position pos angle q theta actual measured ist istwert winkel lage angles positions joint "
     "encoder enc geber motor link reference ref truth angulaire deg rad rotation phi feedback data "
     "laser posicion posici\u00f3n posizione angulo \u00e1ngulo angolo referencia riferimento skala scale "},
};

/// The reference is the one of two positions of a joint that is nearer to the load, or that of a sensor which
/// is no part of the robot: words of the motor's side, of the load's, and of such sensors, which count twice.
constexpr std::string_view motor_words =
    " motor rotor drive enc encoder geber codeur codificador input primary theta hall actuator ";
constexpr std::string_view load_words = " link load output arm secondary second abtrieb sortie target_link ";
constexpr std::string_view sensor_words =
    " ref reference referenz referencia riferimento truth true ext extern external laser tracker mocap vicon "
    "vrpn optitrack "
    "qualisys leica "
    "faro marker "
    "autocollimator collimator interferometer gauge ";

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
  if (exact.unit == "-") return {exact.name, {}};  // none
  if (!exact.unit.empty()) {
    std::string unit = unit_in_words(exact.unit);
    if (unit.empty()) unit = unit_in_capitals(exact.unit);
    // `q[1]` is the second of a list, `a1.effort [1]` an effort in an arbitrary unit.
    const bool digits = std::ranges::all_of(exact.unit, [](char c) { return c >= '0' && c <= '9'; });
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
    const bool elsewhere = !meaning.mapped && std::ranges::any_of(sources, [&](const LogSource& s) {
      return s.signal == parts.name;
    });
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
  const bool libfranka = std::ranges::any_of(
      header, [](const std::string& cell) { return cell == "success rate" || cell == "success_rate"; });
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

bool GuessedColumn::whole() const {
  return std::ranges::all_of(values, [](double v) { return v == std::floor(v); });
}

double GuessedColumn::largest() const {
  double most = 0;
  for (const double v : values) most = std::max(most, std::abs(v));
  return most;
}

double GuessedColumn::smallest_step() const {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < values.size(); ++i)
    if (const double step = std::abs(values[i] - values[i - 1]); step > 0) least = std::min(least, step);
  return std::isinf(least) ? 0 : least;
}

bool has_word(std::string_view words, const std::string& word) {
  return words.find(' ' + word + ' ') != std::string_view::npos;
}

std::vector<std::string> words_in(const std::string& name) {
  std::vector<std::string> words;
  char before = ' ';
  for (const char c : name) {
    const auto u = static_cast<unsigned char>(c);
    const bool digit = c >= '0' && c <= '9', upper = c >= 'A' && c <= 'Z';
    const bool letter = upper || (c >= 'a' && c <= 'z') || u >= 0x80;
    const bool was_digit = before >= '0' && before <= '9', was_lower = before >= 'a' && before <= 'z';
    const bool begins = before == ' ' || digit != was_digit || (upper && was_lower);
    if (digit || letter) {
      if (begins) words.emplace_back();
      words.back() += static_cast<char>(upper ? c + 32 : c);
    }
    before = digit || letter ? c : ' ';
  }
  return words;
}

ColumnRole role_of(const std::vector<std::string>& words) {
  const auto any = [&](std::string_view of) {
    return std::ranges::any_of(words, [&](const std::string& word) { return has_word(of, word); });
  };
  for (const RoleWords& row : role_words)
    if (any(row.words))
      // libfranka's tau_ext is what it estimates of contacts.
      return row.role == ColumnRole::effort && any(" ext ") ? ColumnRole::other : row.role;
  return ColumnRole::none;
}

bool is_known_word(const std::string& word) {
  return role_of({word}) != ColumnRole::none || side_of(word) != 0;
}

bool is_of_sensor(const std::string& word) { return has_word(sensor_words, word); }

int side_of(const std::string& word) {
  return 2 * has_word(sensor_words, word) + has_word(load_words, word) - has_word(motor_words, word);
}

std::vector<double> numbers_of(const std::vector<std::string>& texts) {
  std::vector<double> numbers;
  LogClock clock;
  WrittenNumbers written;
  for (std::string text : texts) {
    if (!make_decimal_notation(text)) make_plain_number(text);
    if (const auto number = parse_number(text))
      numbers.push_back(*number);
    else if (const auto stamp = clock.seconds(text, Unit{}, written))
      numbers.push_back(*stamp);
  }
  return numbers;
}

double correlation_of(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = std::ssize(x);
  if (x.size() != y.size() || x.size() < 10) return 0;
  const Eigen::Map<const Eigen::ArrayXd> a(x.data(), n), b(y.data(), n);
  const Eigen::ArrayXd da = a - a.mean(), db = b - b.mean();
  const double norm = std::sqrt(da.square().sum() * db.square().sum());
  return norm > 0 ? (da * db).sum() / norm : 0;
}

}  // namespace qerr
