#include "report/diagnosis/extended_reading.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "qerr/effect/effect_kind.hpp"
#include "report/csv_text.hpp"
#include "report/diagnosis/parts.hpp"

namespace qerr {

namespace {

/// Whether the reading contains the effect's action.
bool acts(const EffectKind& kind) {
  return kind.action && kind.stage != Stage::log && !kind.random() && !kind.replay;
}

/// The path at any time, linear between its rows and constant beyond them.
double at(const Evidence& e, double time) {
  const double* first = e.time.data();
  const double* last = first + e.rows();
  const auto after = std::upper_bound(first, last, time) - first;
  if (after == 0) return e.path[0];
  if (after == e.rows()) return e.path[e.rows() - 1];
  const double span = e.time[after] - e.time[after - 1];
  return e.path[after - 1] + (e.path[after] - e.path[after - 1]) * (time - e.time[after - 1]) / span;
}

}  // namespace

ExtendedReading::ExtendedReading(const std::vector<Effect>& effects, const Encoder& encoder)
    : resolution_(encoder.resolution) {
  for (const EffectKind& kind : effect_kinds())
    for (const Effect& effect : effects)
      if (effect.type == kind.name && acts(kind))
        steps_.push_back({kind.stage, kind.action(effect, encoder, 0)});
  std::stable_sort(steps_.begin(), steps_.end(),
                   [](const Step& a, const Step& b) { return a.stage < b.stage; });
}

double ExtendedReading::sampled_at(double time) const {
  for (const Step& s : steps_)
    if (s.stage == Stage::clock) time = s.action(time, {});
  return time;
}

double ExtendedReading::operator()(double position, const Moment& moment) const {
  for (const Step& s : steps_) {
    if (s.stage == Stage::clock || s.stage == Stage::reference) continue;
    position = s.stage == Stage::decoder ? resolution_ * s.action(position / resolution_, moment)
                                         : s.action(position, moment);
  }
  return position;
}

double ExtendedReading::reference(double position, const Moment& moment) const {
  for (const Step& s : steps_)
    if (s.stage == Stage::reference) position = s.action(position, moment);
  return position;
}

Eigen::ArrayXd explained(const Evidence& e, const std::vector<Effect>& effects) {
  const ExtendedReading reading(effects, e.encoder);
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(e.rows());
  for (const Effect& effect : effects)
    if (const auto replay = effect_kind(effect.type).replay) sum += replay(effect, e);
  for (Eigen::Index k = 0; k < e.rows(); ++k) {
    // Without a clock effect the interpolation error of the path must not appear as an effect.
    const double sampled = reading.sampled_at(e.time[k]);
    const double truth = e.ordered && sampled != e.time[k] ? at(e, sampled) : e.path[k];
    const Moment moment{static_cast<std::uint64_t>(k), e.time[k], truth, e.effort.size() ? e.effort[k] : 0,
                        e.temperature.size() ? e.temperature[k] : 0};
    sum[k] += reading(truth, moment) - reading.reference(e.path[k], moment);
  }
  return sum;
}

bool fits_table(const Effect& effect) { return effect_kind(effect.type).table.has_value(); }

namespace {

constexpr double turn = 2 * std::numbers::pi;
constexpr double most_rows = 1e6;

/// Equidistant positions of the correction table of an encoder.
struct Grid {
  double from = 0, to = 0;
  std::size_t intervals = 64;
  bool repeats = true;  ///< from one revolution of the encoder's shaft to the next
};

bool is_whole(double x) { return std::abs(x - std::round(x)) < 1e-9 * std::max(1.0, std::abs(x)); }

/// Positions fine enough for the shortest period.
/// @param effects  each with a table
Grid grid_of(const Evidence& e, const std::vector<Effect>& effects) {
  const double revolution = turn / std::abs(e.encoder.shaft_ratio);
  Grid grid{0, revolution, 64, true};
  double shortest_period = revolution;
  int points = 64;
  for (const Effect& effect : effects) {
    const TableShape& shape = *effect_kind(effect.type).table;
    const double length = shape.period ? shape.period(effect, e.encoder) : 0;
    grid.repeats = grid.repeats && !shape.linear && (length == 0 || is_whole(revolution / length));
    if (length > 0) shortest_period = std::min(shortest_period, length);
    points = std::max(points, shape.points_per_period);
  }
  if (!grid.repeats) grid.from = e.measured.minCoeff(), grid.to = e.measured.maxCoeff();
  const double intervals = std::ceil(points * (grid.to - grid.from) / shortest_period);
  if (!(intervals < most_rows))
    throw Error(Fault{{},
                      "--write-table",
                      "the table of joint '" + e.joint + "' would have too many rows",
                      shortest(intervals),
                      "the effects' periods are too short for a table"},
                Trouble::usage);
  grid.intervals = static_cast<std::size_t>(std::max(intervals, 64.0));
  return grid;
}

/// True position minus `measured`, by fixed-point iteration: the errors change slowly with the position.
double correction(const ExtendedReading& reading, double measured) {
  double position = measured;
  for (int i = 0; i < 50; ++i) {
    const double off = reading(position, {.joint = position}) - measured;
    position -= off;
    if (std::abs(off) < 1e-15 * std::max(1.0, std::abs(measured))) break;
  }
  return position - measured;
}

std::string rows_of(const Evidence& e, const std::vector<Effect>& effects) {
  const ExtendedReading reading(effects, e.encoder);
  const Grid grid = grid_of(e, effects);
  std::string out;
  for (std::size_t i = 0; i <= grid.intervals; ++i) {
    const double measured =
        grid.from + (grid.to - grid.from) * static_cast<double>(i) / static_cast<double>(grid.intervals);
    out += csv_cell(e.joint) + ',' + shortest(measured * std::abs(e.encoder.shaft_ratio)) + ',' +
           shortest(measured) + ',' + shortest(correction(reading, measured)) + ',' +
           (e.prismatic ? "m" : "rad") + "\r\n";
  }
  return out;
}

}  // namespace

std::string correction_table(const DiagnosisReport& r) {
  std::string head =
      "# qerr diagnose " + std::string(version()) + " of " + escaped(r.log.file) +
      ": corrected position = measured + correction, linear between rows.\r\n"
      "# measured: counts times resolution, at the joint's side of the gear, before any coupling; "
      "encoder_angle: of the encoder's shaft.\r\n";
  std::string rows;
  for (const Evidence& e : evidence(r.spec.model, r.log, all_encoders(r.spec.model))) {
    std::vector<Effect> held;
    for (const Cause& c : r.diagnosis.causes) {
      if (c.effect.joint != e.joint) continue;
      if (fits_table(c.effect))
        held.push_back(c.effect);
      else
        head += "# not in this table: " + c.effect.type + " of " + escaped(e.joint) + "\r\n";
    }
    if (held.empty()) continue;
    head += "# " + escaped(e.joint) +
            (grid_of(e, held).repeats ? ": one revolution of the encoder; it repeats with every other"
                                      : ": over the positions of the log") +
            "\r\n";
    rows += rows_of(e, held);
  }
  return head + "joint,encoder_angle [rad],measured,correction,unit\r\n" + rows;
}

}  // namespace qerr
