#include <cmath>
#include <numbers>

#include "core/lists.hpp"
#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "qerr/report/analysis.hpp"
#include "report/analysis/figures.hpp"
#include "report/formats.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// Largest entry of the position rows of J C over the configurations, encoder by encoder [m/rad or 1].
Eigen::VectorXd largest_arms(const Spec& spec, unsigned threads) {
  OperationalModel model = spec.model;
  model.coordinates = {Coordinate::x, Coordinate::y, Coordinate::z};
  model.lengths.clear();
  model.signals.clear();
  WorkspaceOptions options;
  options.threads = threads;
  return workspace(model, {}, spec.configurations, options).largest_arms;
}

/// The first of the spec.
const NamedFilter& derivative_filter(const Spec& spec) {
  for (const NamedFilter& f : spec.filters)
    if (f.filter.derivative > 0) return f;
  throw spec_error(spec, "filters", "a threshold velocity needs the sample rate of a derivative filter", "",
                   "add filters: {velocity: {derivative: 1, sample_rate: 1 kHz}}");
}

/// What an encoder moves, in metres per radian (or metre) of it.
struct Moved {
  std::size_t joint = 0;
  double length = 0;    ///< [m]
  double coupling = 1;  ///< |C_ji|
  double travel = 0;    ///< [m/rad or 1]
};

/// The joint j that encoder i moves farthest: l |C_ji| at the distance l from a revolute joint, |C_ji| along
/// a prismatic one, for joint angles C * encoder angles.
Moved farthest_joint(const OperationalModel& model, Eigen::Index encoder, double length) {
  Moved best;
  for (std::size_t j = 0; j < model.chain.independent.size(); ++j) {
    const double factor = std::abs(model.transmission.coupling(j, encoder));
    const double travel = factor * (model.chain.independent[j].prismatic() ? 1.0 : length);
    if (travel > best.travel) best = {j, length, factor, travel};
  }
  return best;
}

/// The rows whose coupling is a factor of the resolution.
std::string couplings(const ThresholdReport& report, std::size_t width) {
  std::string out;
  for (const ThresholdRow& r : report.rows)
    if (r.coupling != 1)
      out += wrapped(escaped(r.robot, 40) + ": both times " + significant(r.coupling, 4) +
                         ", the `coupling` of joint '" + escaped(r.joint, 40) + "' to the encoder",
                     width, "  ");
  return out;
}

/// Whose sample rates the velocities are of.
std::string filters(const ThresholdReport& report, std::size_t width) {
  std::vector<std::string> names;
  for (const ThresholdRow& r : report.rows)
    if (const std::string name = quoted(r.filter); !contains(names, name)) names.push_back(name);
  return wrapped("rate: of filter " + joined(names) + ", the first of its spec that takes a derivative",
                 width, "  ");
}

}  // namespace

ThresholdRow threshold_row(const Spec& spec, unsigned threads) {
  ThresholdRow best;
  best.robot = spec.robot_name;
  best.filter = derivative_filter(spec).name;
  best.sample_rate = derivative_filter(spec).filter.sample_rate;
  const Transmission& transmission = spec.model.transmission;
  const Eigen::VectorXd arms = spec.threshold_length ? Eigen::VectorXd() : largest_arms(spec, threads);
  for (std::size_t i = 0; i < spec.encoder_figures.size(); ++i) {
    const auto encoder = static_cast<Eigen::Index>(i);
    const Moved moved = spec.threshold_length ? farthest_joint(spec.model, encoder, *spec.threshold_length)
                                              : Moved{i, arms[encoder], 1, arms[encoder]};
    const double resolution = moved.travel * transmission.encoders[i].resolution;
    if (i > 0 && !(resolution > best.resolution)) continue;
    const IndependentJoint& joint = spec.model.chain.independent[moved.joint];
    best.joint = joint.name;
    best.counts_per_rev = spec.encoder_figures[i].counts_per_rev;
    best.gear_ratio = spec.encoder_figures[i].gear_ratio;
    best.coupling = moved.coupling;
    best.length = moved.length;
    best.resolution = resolution;
    best.resolution_as_printed = joint.prismatic() ? resolution : resolution / (2 * std::numbers::pi);
  }
  constexpr double rounding = 1e-12;  // [m/rad] of an arm whose tip is on the axis
  if (!spec.threshold_length && !(arms.maxCoeff() > rounding))
    throw spec_error(spec, "threshold.length",
                     "no joint moves the position of the tip: it has no threshold velocity", "",
                     "add threshold: {length: 300 mm}, the distance of a point from the axis");
  return best;
}

std::string to_csv(const ThresholdReport& r, const Style&) {
  return csv_of(r.rows, {"joint", "coupling", "filter"});
}

RowsOf<ThresholdRow> rows(Of<ThresholdRow>) {
  return {{"robot", &ThresholdRow::robot},
          {"joint", &ThresholdRow::joint, "with the largest resolution at the tip"},
          {"counts_per_rev", &ThresholdRow::counts_per_rev, nullable},
          {"gear_ratio", &ThresholdRow::gear_ratio, nullable},
          {"coupling", &ThresholdRow::coupling, nullable},
          {"length_mm", [](auto& r) { return 1e3 * r.length; }, nullable},
          {"sample_rate_hz", &ThresholdRow::sample_rate, nullable},
          {"filter", &ThresholdRow::filter, "whose rate it is: the first that takes a derivative"},
          {"resolution_mm", [](auto& r) { return 1e3 * r.resolution; }, nullable},
          {"threshold_velocity_mm_s", [](auto& r) { return 1e3 * r.threshold_velocity(); }, nullable},
          {"resolution_mm_as_printed", [](auto& r) { return 1e3 * r.resolution_as_printed; }, nullable},
          {"threshold_velocity_mm_s_as_printed",
           [](auto& r) { return 1e3 * r.threshold_velocity_as_printed(); }, nullable}};
}

RowsOf<ThresholdReport> rows(Of<ThresholdReport>) {
  return header<ThresholdReport>("threshold").with({{"robots", &ThresholdReport::rows}});
}

std::string to_table(const ThresholdReport& report, const Style& style) {
  TableRows cells{{"robot", "counts/rev", "gear", "length", "rate", "resolution", "threshold",
                   "l/(nG) as printed", "as printed"}};
  for (const ThresholdRow& r : report.rows)
    cells.push_back({escaped(r.robot, 40), significant(r.counts_per_rev, 7), significant(r.gear_ratio, 7),
                     readable(r.length, "m"), readable(r.sample_rate, "Hz"), readable(r.resolution, "m"),
                     readable(r.threshold_velocity(), "m/s"), readable(r.resolution_as_printed, "m"),
                     readable(r.threshold_velocity_as_printed(), "m/s")});
  return painted("Resolution and threshold velocity (Table IV): one count per sample", Paint::bold, style) +
         "\n" + fitted_table(cells, style.width) +
         wrapped(
             "resolution = 2 pi l/(n G); the paper prints l/(n G), which lacks the 2 pi of a revolute joint",
             style.width, "  ") +
         filters(report, style.width) + couplings(report, style.width);
}

}  // namespace qerr
