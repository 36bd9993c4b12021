#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "control/loop.hpp"
#include "core/search.hpp"

namespace qerr {

namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

constexpr int halvings = 60;  // of an interval: to the last bit of a double

/// Amplitudes are in half widths of the play.
Complex of_play(double amplitude, bool behind) {
  if (!behind) return {1, 4 / (pi * amplitude)};
  const double b = 1 - 2 / amplitude, s = 1 - b * b;
  return {(0.5 * pi + std::asin(b) + b * std::sqrt(s)) / pi, -s / pi};
}

/// The amplitude at which N has an angle, which falls from pi/2 to 0 while it grows.
double amplitude_of(double angle, bool behind) {
  if (!behind) return 4 / (pi * std::tan(angle));
  const auto lags_more = [&](double amplitude) { return -std::arg(of_play(amplitude, true)) > angle; };
  Change at{1, 2};
  for (; lags_more(at.fails); at.fails *= 2) at.holds = at.fails;
  return bisect(at, halvings, lags_more).holds;
}

Complex value(const PolynomialInW& p, const Complex& w) {
  Complex sum = 0;
  for (std::size_t k = p.size(); k-- > 0;) sum = sum * w + static_cast<double>(p[k]);
  return sum;
}

}  // namespace

std::optional<PlayCycle> play_cycle(const Loop& loop, double play, bool behind) {
  const TransferRatio ratio = loop.open();
  const auto open = [&](double frequency) {
    const Complex w(0, std::tan(pi * frequency / loop.sample_rate));
    return value(ratio.b, w) / value(ratio.a, w);
  };
  // Angle of -L: N makes up for it where it lags behind the play, and leads on the other side.
  const auto lacking = [&](const Complex& l) { return (behind ? 1 : -1) * std::arg(-l); };
  /// |L N| at the amplitude of the frequency; 0 or infinite beyond the least one, empty where there is none.
  const auto gain = [&](double frequency) -> std::optional<double> {
    const Complex l = open(frequency);
    const double angle = lacking(l);
    if (!(angle > 1e-6)) return std::nullopt;
    if (angle >= 0.5 * pi) return behind ? 0 : std::numeric_limits<double>::infinity();
    return std::abs(l) * std::abs(of_play(amplitude_of(angle, behind), behind));
  };
  constexpr int samples = 600;
  constexpr double lowest = 1e-6;  // of half the sample rate
  std::optional<PlayCycle> largest;
  std::optional<double> before;
  double last = 0;
  for (int i = 0; i < samples; ++i) {
    const double frequency =
        0.5 * loop.sample_rate * std::pow(lowest, 1 - (i + 0.5) / static_cast<double>(samples));
    const std::optional<double> here = gain(frequency);
    if (before && here && (*before > 1) != (*here > 1)) {
      const Change at = bisect({last, frequency}, halvings,
                               [&](double f) { return (gain(f).value_or(1) > 1) == (*before > 1); });
      const double found = lacking(open(at.holds)) < 0.5 * pi ? at.holds : at.fails,
                   amplitude = 0.5 * play * amplitude_of(lacking(open(found)), behind);
      if (!largest || amplitude > largest->amplitude) largest = PlayCycle{amplitude, found};
    }
    before = here;
    last = frequency;
  }
  return largest;
}

}  // namespace qerr
