#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/parallel.hpp"
#include "diagnose/record/with_effects.hpp"
#include "effect/action_path.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/page/page.hpp"
#include "report/rows.hpp"

namespace qerr {

namespace {

/// Whether a look-up table can compensate an effect: its error is a smooth function of the position alone.
bool fits_table(const Effect& effect) { return effect_kind(effect.type).table.has_value(); }

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
    throw Error("--write-table", "the table of joint '" + e.joint + "' would have too many rows",
                shortest(intervals), "the effects' periods are too short for a table", Trouble::usage);
  grid.intervals = static_cast<std::size_t>(std::max(intervals, 64.0));
  return grid;
}

ActionPath actions(const std::vector<Effect>& effects, const Encoder& encoder) {
  ActionPath all;
  for (const Effect& effect : effects) {
    const EffectKind& kind = effect_kind(effect.type);
    all.add(kind, kind.action(effect, encoder, 0));
  }
  return all;
}

/// True position minus `measured`, by fixed-point iteration: the errors change slowly with the position.
double correction(const ActionPath& actions, double measured) {
  double position = measured;
  for (int i = 0; i < 50; ++i) {
    const double reading = actions(position, {.joint = position});
    position -= reading - measured;
    if (std::abs(reading - measured) < 1e-15 * std::max(1.0, std::abs(measured))) break;
  }
  return position - measured;
}

std::string rows_of(const Evidence& e, const std::vector<Effect>& effects) {
  const ActionPath of_effects = actions(effects, e.encoder);
  const Grid grid = grid_of(e, effects);
  std::string out;
  for (std::size_t i = 0; i <= grid.intervals; ++i) {
    const double measured =
        grid.from + (grid.to - grid.from) * static_cast<double>(i) / static_cast<double>(grid.intervals);
    out += csv_cell(e.joint) + ',' + shortest(measured * std::abs(e.encoder.shaft_ratio)) + ',' +
           shortest(measured) + ',' + shortest(correction(of_effects, measured)) + ',' +
           (e.prismatic ? "m" : "rad") + "\r\n";
  }
  return out;
}

constexpr Eigen::Index position_bins = 4096;

std::vector<Effect> effects_of(const DiagnosisReport& r, const std::string& joint) {
  std::vector<Effect> list;
  for (const Cause& c : r.diagnosis.causes)
    if (c.effect.joint == joint) list.push_back(c.effect);
  return list;
}

JointResidual residual_of(const DiagnosisReport& r, Evidence e) {
  const std::vector<Effect> effects = effects_of(r, e.joint);
  JointResidual out{std::move(e), {}, {}};
  out.before = out.evidence.measured - out.evidence.reference;
  out.after = out.before;
  if (!effects.empty()) out.after -= with_effects(out.evidence, effects).path - out.evidence.path;
  return out;
}

/// Means over equal intervals of the range, minus the overall mean; NaN in an interval without samples.
Eigen::ArrayXd means_by_position(const Eigen::ArrayXd& position, const Eigen::ArrayXd& residual) {
  const double from = position.minCoeff(), span = position.maxCoeff() - from;
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(position_bins), count = Eigen::ArrayXd::Zero(position_bins);
  for (Eigen::Index k = 0; k < position.size(); ++k) {
    const auto bin = std::min<Eigen::Index>(
        position_bins - 1, static_cast<Eigen::Index>(position_bins * (position[k] - from) / span));
    sum[bin] += residual[k];
    count[bin] += 1;
  }
  const double mean = residual.mean();
  return (count > 0).select(sum / count.max(1) - mean, std::nan(""));
}

/// Amplitudes of half a wave over the range, of two halves, ... up to half the intervals.
std::vector<double> amplitudes(const Eigen::ArrayXd& means) {
  std::vector<double> padded(2 * position_bins, 0.0);
  double filled = 0;
  for (Eigen::Index b = 0; b < position_bins; ++b)
    if (!std::isnan(means[b])) padded[b] = means[b], ++filled;
  const auto spectrum = half_spectrum(padded);
  std::vector<double> amplitude;
  for (std::size_t n = 1; n <= position_bins / 2; ++n)
    amplitude.push_back(2 * std::abs(spectrum[n]) / filled);
  return amplitude;
}

std::string residual_rows(const JointResidual& residual) {
  const Evidence& e = residual.evidence;
  const std::string joint = csv_cell(e.joint) + ',', unit = e.prismatic ? ",m\r\n" : ",rad\r\n";
  std::string out;
  for (Eigen::Index k = 0; k < e.rows(); ++k)
    out += joint + (e.ordered ? shortest(e.time[k]) : "") + ',' + shortest(e.reference[k]) + ',' +
           shortest(e.direction.size() ? e.direction[k] : 0) + ',' + shortest(residual.before[k]) + ',' +
           shortest(residual.after[k]) + unit;
  return out;
}

std::string spectrum_rows(const JointResidual& residual) {
  const Evidence& e = residual.evidence;
  const std::string joint = csv_cell(e.joint) + ',', unit = e.prismatic ? ",m\r\n" : ",rad\r\n";
  const PositionSpectrum s = position_spectrum(residual);
  std::string out;
  for (std::size_t i = 0; i < s.order.size(); ++i)
    out += joint + shortest(s.order[i]) + ',' + shortest(s.encoder_order[i]) + ',' + shortest(s.before[i]) +
           ',' + shortest(s.after[i]) + unit;
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

void for_each_residual(const DiagnosisReport& r, const std::function<void(const JointResidual&)>& task) {
  constexpr std::size_t rows_at_once = 1 << 21;
  if (r.log.values.size() == 0) return;
  const std::vector<std::size_t> encoders = all_encoders(r.spec.model);
  const std::size_t rows = std::max<std::size_t>(1, static_cast<std::size_t>(r.log.values.rows()));
  const std::size_t at_once = std::max<std::size_t>(1, rows_at_once / rows);
  for (std::size_t first = 0; first < encoders.size(); first += at_once) {
    const std::size_t end = std::min(first + at_once, encoders.size());
    std::vector<Evidence> some = evidence(
        r.spec.model, r.log, {encoders.begin() + first, encoders.begin() + static_cast<std::ptrdiff_t>(end)});
    parallel_for(some.size(), 0, [&](std::size_t i) { task(residual_of(r, std::move(some[i]))); });
  }
}

PositionSpectrum position_spectrum(const JointResidual& residual) {
  const Evidence& e = residual.evidence;
  const double span = e.reference.maxCoeff() - e.reference.minCoeff();
  if (!(span > 0)) return {};
  PositionSpectrum s{{}, {}, amplitudes(means_by_position(e.reference, residual.before)), {}};
  s.after = (residual.before == residual.after).all()
                ? s.before
                : amplitudes(means_by_position(e.reference, residual.after));
  for (std::size_t i = 0; i < s.before.size(); ++i) {
    const double waves = 0.5 * static_cast<double>(i + 1) / span;  // per rad or m
    s.order.push_back(e.prismatic ? waves : 2 * std::numbers::pi * waves);
    s.encoder_order.push_back(2 * std::numbers::pi * waves / std::abs(e.encoder.shaft_ratio));
  }
  return s;
}

ResidualCurves residual_curves(const DiagnosisReport& r) {
  std::vector<ResidualCurves> of_encoder(r.spec.model.transmission.encoders.size());
  for_each_residual(r, [&](const JointResidual& residual) {
    of_encoder[residual.evidence.number] = {residual_rows(residual), spectrum_rows(residual)};
  });
  ResidualCurves out;
  for (const ResidualCurves& one : of_encoder) out.residual += one.residual, out.spectrum += one.spectrum;
  if (!out.residual.empty())
    out.residual.insert(0, "joint,time [s],reference,direction,before,after,unit\r\n");
  if (!out.spectrum.empty()) out.spectrum.insert(0, "joint,order,encoder_order,before,after,unit\r\n");
  return out;
}

}  // namespace qerr
