#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "input/log_clock.hpp"
#include "input/log_columns.hpp"
#include "input/table_format.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

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

bool GuessedColumn::whole() const {
  return std::all_of(values.begin(), values.end(), [](double v) { return v == std::floor(v); });
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
    return std::any_of(words.begin(), words.end(),
                       [&](const std::string& word) { return has_word(of, word); });
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
  const auto n = static_cast<Eigen::Index>(x.size());
  if (x.size() != y.size() || x.size() < 10) return 0;
  const Eigen::Map<const Eigen::ArrayXd> a(x.data(), n), b(y.data(), n);
  const Eigen::ArrayXd da = a - a.mean(), db = b - b.mean();
  const double norm = std::sqrt(da.square().sum() * db.square().sum());
  return norm > 0 ? (da * db).sum() / norm : 0;
}

}  // namespace qerr
