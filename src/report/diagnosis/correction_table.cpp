#include <algorithm>
#include <cmath>
#include <numbers>

#include "qerr/effect/effect_kind.hpp"
#include "report/csv_text.hpp"
#include "report/diagnosis/extended_reading.hpp"
#include "report/diagnosis/parts.hpp"

namespace qerr {

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
