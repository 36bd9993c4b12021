#include "qerr/bound/velocity_estimators.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "core/search.hpp"
#include "effect/action_path.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

/// Rounds a number that is an integer up to the rounding errors of a few operations.
double snapped(double x) {
  const double nearest = std::round(x);
  return std::abs(x - nearest) <= 8 * std::numeric_limits<double>::epsilon() * x ? nearest : x;
}

using Map = std::function<double(double)>;

/// The position that the effects of one stage make of the true one, in turn.
Map positions_behind(Stage stage, const Encoder& encoder, const std::vector<Effect>& effects,
                     const std::string& joint) {
  ActionPath actions;
  for (const Effect& e : effects)
    if (const EffectKind& kind = effect_kind(e.type); e.joint == joint && kind.stage == stage && kind.action)
      actions.add(kind, kind.action(e, encoder, 0));
  return [actions](double x) { return actions(x, {.joint = x}); };
}

/// Displacement of edge k: the x with seen(x) = (k - below) Delta, less its ideal place [rad or m]. Errors
/// within a line are below half a period of it.
double displacement(const Map& seen, const Encoder& encoder, double k) {
  const double ideal = (k - below_reading(encoder)) * encoder.resolution;
  const double half = 0.5 * encoder.counts_per_period * encoder.resolution;
  return bisect({-half, half}, 60, [&](double x) { return seen(ideal + x) < ideal; }).middle();
}

/// Largest |d (seen - x)/dx| of one effect of the disc, over a period or, of one without, a unit.
double slope_of(const Map& seen, double period) {
  constexpr int points = 1024;  // of a sine's largest slope 2e-6 is missed
  const double step = period / points;
  double slope = 0, last = seen(0);
  for (int i = 1; i <= points; ++i) {
    const double next = seen(i * step);
    slope = std::max(slope, std::abs((next - last) / step - 1));
    last = next;
  }
  return slope;
}

}  // namespace

EdgeErrors edge_errors(const Encoder& encoder, const std::vector<Effect>& effects, const std::string& joint) {
  EdgeErrors edges;
  constexpr double most = 4096;
  const Map seen = positions_behind(Stage::line, encoder, effects, joint);
  const double count = std::ceil(encoder.counts_per_period), stride = std::max(1.0, std::floor(count / most));
  double least = 0, largest = 0;
  for (double k = 0; k < count; k += stride) {
    const double at = displacement(seen, encoder, k) / encoder.resolution;
    const double width = 1 + displacement(seen, encoder, k + 1) / encoder.resolution - at;
    edges.shortest = std::min(edges.shortest, width);
    edges.longest = std::max(edges.longest, width);
    least = k == 0 ? at : std::min(least, at);
    largest = k == 0 ? at : std::max(largest, at);
  }
  constexpr double rounding = 1e-9;  // of the bisection
  edges.spread = largest - least;
  if (edges.spread < rounding) edges = {};
  for (const Effect& e : effects) {
    const double wave = std::abs(wave_number(e, encoder));
    edges.slope += slope_of(positions_behind(Stage::disc, encoder, {e}, joint),
                            wave > 0 ? 2 * std::numbers::pi / wave : 1);
  }
  edges.shortest = std::max(0.0, edges.shortest) / (1 + edges.slope);
  edges.longest =
      edges.slope < 1 ? edges.longest / (1 - edges.slope) : std::numeric_limits<double>::infinity();
  return edges;
}

EstimatorError finite_difference_error(double resolution, double sample_rate, double speed,
                                       const EdgeErrors& edges) {
  const double unit = resolution * sample_rate;
  const double counts = snapped(std::abs(speed) / unit), off = counts * edges.slope;
  const double most = std::ceil(counts + off + 1 + edges.spread) - 1;
  const double least = std::floor(counts - off - 1 - edges.spread) + 1;
  return {unit, unit * (1 + edges.spread + off), unit * std::max(most - counts, counts - least)};
}

EstimatorError inverse_time_error(double resolution, double clock, double speed, const EdgeErrors& edges) {
  const double unit = resolution * clock;
  if (speed == 0) return {};
  const double alpha = snapped(unit / std::abs(speed));
  const double m = std::floor(alpha), least = std::floor(snapped(alpha * edges.shortest)),
               most = std::ceil(snapped(alpha * edges.longest));
  constexpr double unbounded = std::numeric_limits<double>::infinity();
  const double printed = m < 1 ? unbounded : unit / m;
  if (least < 1 || !std::isfinite(most)) return {printed, unbounded, unbounded};
  const double above = 1 / least - edges.shortest / (least + 1);
  const double below = std::max(1 / alpha - 1 / most, edges.longest / most - 1 / (most + 1));
  const double constant = std::max({0.0, 1 / least - 1 / alpha, 1 / alpha - 1 / most});
  return {printed, unit * std::max(above, below), unit * constant};
}

double estimator_crossing(double resolution, double sample_rate, double clock, const EdgeErrors& edges) {
  const double ratio = clock / sample_rate;
  // (m - 1) m < m^2 <= ratio < (m + 1)^2: the least integer is m or the next one.
  double m = std::max(1.0, std::floor(std::sqrt(ratio)));
  if (m * (m + 1) < ratio) m += 1;
  if (edges.ideal()) return resolution * clock / m;
  const auto better = [&](double speed) {
    return inverse_time_error(resolution, clock, speed, edges).varying <=
           finite_difference_error(resolution, sample_rate, speed, edges).varying;
  };
  return bisect({0, resolution * clock}, 100, better).holds;  // at its end two edges may share a tick
}

double worst_case_snr_db(double speed, double error) { return 20 * std::log10(std::abs(speed) / error); }

}  // namespace qerr
