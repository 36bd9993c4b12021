#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/search.hpp"
#include "filter/corners.hpp"
#include "filter/tracking_error.hpp"

namespace qerr {
namespace {

// Gauss and Kronrod, 7 and 15 nodes on [-1, 1] (Piessens et al., QUADPACK, 1983): the nodes above 0, those of
// Gauss at odd indices, and 0.
constexpr std::array<double, 8> nodes{
    0.991455371120812639, 0.949107912342758525, 0.864864423359769073, 0.741531185599394440,
    0.586087235467691130, 0.405845151377397167, 0.207784955007898468, 0};
constexpr std::array<double, 8> kronrod{0.022935322010529225, 0.063092092629978553, 0.104790010322250184,
                                        0.140653259715525919, 0.169004726639267903, 0.190350578064785410,
                                        0.204432940075298892, 0.209482141084727828};
constexpr std::array<double, 4> gauss{0.129484966168869693, 0.279705391489276668, 0.381830050505118945,
                                      0.417959183673469388};
constexpr double wanted = 1e-11;  // relative difference of both rules: Kronrod's is much more accurate
constexpr std::size_t most_panels = 20000;  // about 1 s for a filter of order 20
constexpr double promising = 0.8;  // of the largest value at a node; a resolved peak rises less between nodes

/// A tracking error at a frequency.
struct BandSample {
  double frequency, error;
};

/// A part of the band, and the integral of the squared error over it.
struct Panel {
  double from = 0, to = 0, integral = 0, uncertainty = 0;
  std::array<BandSample, 15> readings{};  // in the order of frequency
};

Panel panel(const TrackingError& tracking, double from, double to) {
  Panel p{from, to, 0, 0, {}};
  const double center = 0.5 * (from + to), half = 0.5 * (to - from);
  double coarse = 0;
  for (std::size_t i = 0; i < 15; ++i) {
    const std::size_t k = std::min(i, 14 - i);
    const double frequency = center + (i < 7 ? -half : half) * nodes[k];
    const double error = tracking(frequency);
    p.readings[i] = {frequency, error};
    p.integral += half * kronrod[k] * error * error;
    if (k % 2 == 1) coarse += half * gauss[k / 2] * error * error;
  }
  p.uncertainty = std::abs(p.integral - coarse);
  return p;
}

/// The ends of the band and, within it, the frequencies at which the response bends: of poles and zeros, and
/// the flanks of resonances.
std::vector<double> breakpoints(const Filter& filter, double from, double to) {
  std::vector<double> list{from, to};
  const Corners c = corners(filter);
  for (const auto* roots : {&c.zeros, &c.poles})
    for (const std::complex<double>& w : *roots)
      for (const double at : {std::abs(w), w.imag() - w.real(), w.imag(), w.imag() + w.real()}) {
        const double frequency = filter.sample_rate / std::numbers::pi * std::atan(at);
        if (frequency > from && frequency < to) list.push_back(frequency);
      }
  // Taps have lobes of the width of the sample rate over their number.
  const auto lobes = static_cast<std::size_t>(std::min(
      (to - from) / filter.sample_rate * static_cast<double>(filter.taps.size()), 0.5 * most_panels));
  for (std::size_t i = 1; i < lobes; ++i)
    list.push_back(from + (to - from) * static_cast<double>(i) / static_cast<double>(lobes));
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
  return list;
}

/// Panels over the whole band, halved where both rules differ, until they agree.
std::vector<Panel> resolved(const Filter& filter, const TrackingError& tracking, double from, double to) {
  std::vector<Panel> panels;
  const std::vector<double> breaks = breakpoints(filter, from, to);
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
    panels.push_back(panel(tracking, breaks[i], breaks[i + 1]));
  for (std::size_t before = 0; panels.size() != before && panels.size() < most_panels;) {
    before = panels.size();
    double integral = 0;
    for (const Panel& p : panels) integral += p.integral;
    std::vector<Panel> finer;
    for (const Panel& p : panels) {
      const double middle = 0.5 * (p.from + p.to);
      if (!(p.uncertainty * static_cast<double>(before) > wanted * integral) || middle <= p.from ||
          middle >= p.to) {
        finer.push_back(p);
      } else {
        finer.push_back(panel(tracking, p.from, middle));
        finer.push_back(panel(tracking, middle, p.to));
      }
    }
    panels = std::move(finer);
  }
  return panels;
}

double largest_error(const TrackingError& tracking, const std::vector<Panel>& panels) {
  std::vector<BandSample> all{{panels.front().from, tracking(panels.front().from)}};
  for (const Panel& p : panels) {
    all.insert(all.end(), p.readings.begin(), p.readings.end());
    all.push_back({p.to, tracking(p.to)});
  }
  double largest = 0;
  for (const BandSample& r : all) largest = std::max(largest, r.error);
  const double candidate = promising * largest;
  for (std::size_t i = 1; i + 1 < all.size(); ++i)
    if (all[i].error >= candidate && all[i].error >= all[i - 1].error && all[i].error >= all[i + 1].error)
      largest =
          std::max(largest, golden_section(all[i - 1].frequency, all[i + 1].frequency, 45, tracking).value);
  return largest;
}

}  // namespace

BandTracking band_tracking(const Filter& filter, double from, double to) {
  const TrackingError tracking(filter);
  const std::vector<Panel> panels = resolved(filter, tracking, from, to);
  double integral = 0;
  for (const Panel& p : panels) integral += p.integral;
  return {largest_error(tracking, panels), std::sqrt(integral / (to - from))};
}

}  // namespace qerr
