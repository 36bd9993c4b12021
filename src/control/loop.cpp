#include "control/loop.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "core/search.hpp"
#include "filter/run/cascade.hpp"

namespace qerr {
double Control::samples_of_delay(std::size_t joint) const {
  const double samples = (delay + joints[joint].reading.delay) * sample_rate;
  return std::abs(samples - std::round(samples)) < 1e-9 ? std::round(samples) : samples;
}

Eigen::VectorXd widths_at_rest(const Control& control, const Eigen::VectorXd& resolutions) {
  Eigen::VectorXd widths = resolutions;
  for (Eigen::Index j = 0; j < widths.size(); ++j)
    widths[j] = 2 * control.joints[j].reading.half_width(resolutions[j]);
  return widths;
}

ResponseSums response_sums(const Filter& f) {
  const Norms n = norms(f);
  const double first = impulse_response(f, 1).front();
  return {first, n.l1.upper - std::abs(first), n.h2 * n.h2 - first * first, n.dc_gain};
}

double ResponseSums::l1(double k, double d) const {
  return std::abs(k + d * first) + std::abs(d) * later_sum;
}

double ResponseSums::h2(double k, double d) const {
  return std::sqrt(std::pow(k + d * first, 2) + d * d * later_squares);
}

namespace {

constexpr double uncertain = 1e-12;       // of a pole's modulus: gains are doubles
constexpr double longest_exponent = 300;  // e^-300 is 0 beside 1, and its series has 170 digits left

/// e^-x by its series. @pre x <= longest_exponent
Binary1024 decay(const Binary1024& x) {
  Binary1024 sum = 0, term = 1;
  for (int k = 1; k < 4000 && abs(term) > 1e-307; ++k) {
    sum += term;
    term *= -x / static_cast<double>(k);
  }
  return sum;
}

/// Position t after a unit force sets in at rest: (t - (1 - e^(-b t/M)) M/b)/b, t^2/(2 M) without damping.
Binary1024 step_response(double inertia, double damping, const Binary1024& t) {
  const Binary1024 x = t * damping / inertia;
  if (x > longest_exponent) return (t - Binary1024(inertia) / damping) / damping;
  Binary1024 sum = 0, term = 0.5;
  for (int k = 3; k < 4000 && abs(term) > 1e-307; ++k) {
    sum += term;
    term *= -x / static_cast<double>(k);
  }
  return t * t * sum / inertia;
}

/// Real and imaginary part of p(j Omega), the latter over Omega, as polynomials in x = Omega^2.
struct Parts {
  PolynomialInW real, imaginary;
};

Parts on_circle(const PolynomialInW& p) {
  Parts parts{{0}, {0}};
  for (std::size_t k = 0; k < p.size(); ++k) {
    PolynomialInW& part = k % 2 == 0 ? parts.real : parts.imaginary;
    part.resize(std::max(part.size(), k / 2 + 1));
    part[k / 2] = k / 2 % 2 == 0 ? p[k] : -p[k];
  }
  return parts;
}

PolynomialInW shifted(PolynomialInW p) {
  p.insert(p.begin(), Binary1024(0));
  return p;
}

PolynomialInW scaled(PolynomialInW p, const Binary1024& factor) {
  for (Binary1024& c : p) c *= factor;
  return p;
}

PolynomialInW squared_magnitude(const Parts& p) {
  return sum(times(p.real, p.real), shifted(times(p.imaginary, p.imaginary)));
}

/// Real part of x conj(y).
PolynomialInW real_part(const Parts& x, const Parts& y) {
  return sum(times(x.real, y.real), shifted(times(x.imaginary, y.imaginary)));
}

/// Imaginary part of x conj(y), over Omega.
PolynomialInW imaginary_part(const Parts& x, const Parts& y) {
  return sum(times(x.imaginary, y.real), scaled(times(x.real, y.imaginary), -1.0));
}

Binary1024 value(const PolynomialInW& p, const Binary1024& x) {
  Binary1024 sum = 0;
  for (std::size_t k = p.size(); k-- > 0;) sum = sum * x + p[k];
  return sum;
}

/// Positive real roots, ascending.
std::vector<Binary1024> positive_roots(PolynomialInW p) {
  remove_rounding(p);
  while (!p.empty() && p.back() == 0) p.pop_back();
  const auto start = std::ranges::find_if(p, [](const Binary1024& c) { return c != 0; });
  std::vector<Binary1024> positive;
  for (const Complex1024& r : roots({p.rbegin(), std::make_reverse_iterator(start)}))
    if (r.im == 0 && r.re > 0) positive.push_back(r.re);
  std::ranges::sort(positive);
  return positive;
}

double frequency(const Binary1024& x, double sample_rate) {
  return std::atan(std::sqrt(static_cast<double>(x))) * sample_rate / std::numbers::pi;
}

struct Critical {
  double gain, frequency;
};

/// Where L is negative, by ascending 1/|L|.
std::vector<Critical> critical_points(const TransferRatio& open, double sample_rate) {
  const Parts b = on_circle(open.b), a = on_circle(open.a);
  const PolynomialInW real = real_part(b, a), size = squared_magnitude(a);
  std::vector<Critical> points;
  for (const Binary1024& x : positive_roots(imaginary_part(b, a)))
    if (const Binary1024 r = value(real, x); r < 0)
      points.push_back({static_cast<double>(-value(size, x) / r), frequency(x, sample_rate)});
  if (open.a.back() * open.b.back() < 0)  // z = -1
    points.push_back({static_cast<double>(-open.a.back() / open.b.back()), 0.5 * sample_rate});
  std::ranges::sort(points, [](auto& x, auto& y) { return x.gain < y.gain; });
  return points;
}

bool is_stable_with(const TransferRatio& open, double gain) {
  return is_stable({open.b, sum(open.a, scaled(open.b, gain))}, uncertain);
}

/// The largest critical gain below 1 just below which an unstable loop is stable.
double largest_stable_gain(const TransferRatio& open, const std::vector<Critical>& critical) {
  for (std::size_t i = critical.size(); i-- > 0;) {
    if (critical[i].gain > 1) continue;
    const double below = i > 0 ? critical[i - 1].gain : 0;
    if (is_stable_with(open, 0.5 * (critical[i].gain + below))) return critical[i].gain;
  }
  return 0;
}

/// @param undelayed  has the same |L|, without the factors 1 + Omega^2 of delays
void set_phase(const TransferRatio& open, const TransferRatio& undelayed, double sample_rate,
               LoopMargins& m) {
  const Parts b = on_circle(open.b), a = on_circle(open.a);
  const PolynomialInW real = real_part(b, a), imaginary = imaginary_part(b, a),
                      above = squared_magnitude(on_circle(undelayed.b)),
                      below = squared_magnitude(on_circle(undelayed.a));
  for (const Binary1024& x : positive_roots(sum(above, scaled(below, -1.0)))) {
    const Binary1024 re = value(real, x), im = value(imaginary, x) * sqrt(x), size = sqrt(re * re + im * im);
    // 180 deg + arg L is the angle of -L.
    const double angle =
        std::abs(std::atan2(static_cast<double>(-im / size), static_cast<double>(-re / size)));
    if (m.phase && *m.phase <= angle) continue;
    m.phase = angle;
    m.crossover = frequency(x, sample_rate);
  }
}

std::optional<double> bandwidth_of(const TransferRatio& open, double sample_rate) {
  TransferRatio t{open.b, sum(open.a, open.b)};
  cancel_at_dc(t);
  const Binary1024 dc = t.b.front() / t.a.front();
  const auto crossings = positive_roots(sum(scaled(squared_magnitude(on_circle(t.b)), 2.0),
                                            scaled(squared_magnitude(on_circle(t.a)), -(dc * dc))));
  if (crossings.empty()) return std::nullopt;
  return frequency(crossings.front(), sample_rate);
}

/// Re L > -1/k at all frequencies: k Re(b conj a) + |a|^2 has no positive root, and is positive at z = -1.
bool never_oscillates(const TransferRatio& open, double sector) {
  const Parts b = on_circle(open.b), a = on_circle(open.a);
  const PolynomialInW p = sum(scaled(real_part(b, a), sector), squared_magnitude(a));
  return positive_roots(p).empty() && value(p, 1) > 0;
}

TransferRatio controller_ratio(const JointController& c) {
  if (c.kd == 0) return {{c.kp}, {1}};
  const TransferRatio h = ratio_of(c.velocity_filter);
  return {sum(scaled(h.a, c.kp), scaled(h.b, c.kd)), h.a};
}

/// Narrows the margins to those where a gain that varies by 1 -+ slope from place to place is largest and
/// least.
void narrow(LoopMargins& m, double slope) {
  if (slope == 0) return;
  for (double& gain : m.critical_gains) gain /= 1 + slope;
  m.gain /= 1 + slope;
  if (m.lower_gain > 0) m.lower_gain = slope < 1 ? m.lower_gain / (1 - slope) : 1;
  m.stable = m.stable && m.gain > 1 && m.lower_gain < 1;
}

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

TransferRatio plant_of(double inertia, double damping, double sample_rate, double late) {
  const Binary1024 period = Binary1024(1) / sample_rate, x = period * damping / inertia,
                   p = x > longest_exponent ? Binary1024(0) : decay(x);
  // (1 - q)^2 (1 - p q) times the samples of the step response; the next coefficient is 0.
  const Binary1024 c1 = -(2 + p), c2 = 1 + 2 * p;
  Binary1024 s[3];
  for (int i = 0; i < 3; ++i) s[i] = step_response(inertia, damping, period * (1 + i - Binary1024(late)));
  return ratio_of_delays({s[0], s[1] + c1 * s[0], late == 0 ? Binary1024(0) : s[2] + c1 * s[1] + c2 * s[0]},
                         {1, -1 - p, p});
}

Filter controller_of(const JointController& c, double sample_rate) {
  if (c.kd == 0) return {{}, c.kp, sample_rate, 0, {1}};
  if (c.velocity_filter.taps.empty()) {
    const Factored poles = poles_of(c.velocity_filter);
    return filter_of(controller_ratio(c), sample_rate, {}, &poles);
  }
  Filter f = c.velocity_filter;
  f.derivative = 0;
  for (DoubleDouble& h : f.taps) h = h * f.gain * DoubleDouble(c.kd);
  f.gain = 1;
  f.taps.front() += DoubleDouble(c.kp);
  return f;
}

TransferRatio Loop::undelayed() const { return {times(plant.b, controller.b), times(plant.a, controller.a)}; }

TransferRatio Loop::open() const {
  TransferRatio r = undelayed();
  for (std::size_t i = 0; i < delays; ++i) r = {times(r.b, {1, -1}), times(r.a, {1, 1})};
  return r;
}

Loop loop_of(const Control& c, std::size_t joint, double inertia) {
  const JointController& j = c.joints[joint];
  const TransferRatio ratio = controller_ratio(j);
  const double delay = c.samples_of_delay(joint), whole = std::floor(delay);
  return {c.sample_rate,
          plant_of(inertia, j.damping.value_or(0), c.sample_rate, delay - whole),
          {scaled(ratio.b, j.reading.factor), ratio.a},
          static_cast<std::size_t>(whole) + 1,
          j.reading};
}

std::optional<ClosedLoop> closed(const Loop& loop) {
  const TransferRatio open = loop.open();
  const PolynomialInW below = sum(open.a, open.b);
  if (!is_stable({open.b, below}, uncertain)) return std::nullopt;
  const auto delays = [&](double sign) {  // 1 -+ w of each
    return std::vector<LinearFactor>(loop.delays, {1.0, sign});
  };
  const Binary1024 of_error = Binary1024(1) / loop.reading.factor;
  return ClosedLoop{filter_of({scaled(loop.undelayed().b, of_error), below}, loop.sample_rate, delays(-1)),
                    filter_of({scaled(times(loop.controller.b, loop.plant.a), of_error), below},
                              loop.sample_rate, delays(1))};
}

LoopMargins margins(const Loop& loop) {
  const TransferRatio open = loop.open();
  LoopMargins m;
  m.stable = is_stable_with(open, 1);
  const std::vector<Critical> critical = critical_points(open, loop.sample_rate);
  for (const Critical& c : critical) m.critical_gains.push_back(c.gain);
  if (!m.stable) {
    m.gain = largest_stable_gain(open, critical);
    narrow(m, loop.reading.slope);
    return m;
  }
  m.gain = std::numeric_limits<double>::infinity();
  for (const Critical& c : critical) {
    if (c.gain <= 1) {
      m.lower_gain = c.gain;
    } else if (!m.critical_frequency) {
      m.gain = c.gain;
      m.critical_frequency = c.frequency;
    }
  }
  set_phase(open, loop.undelayed(), loop.sample_rate, m);
  m.bandwidth = bandwidth_of(open, loop.sample_rate);
  m.absolutely_stable = loop.reading.play == 0 &&
                        never_oscillates(open, 2 * (1 + loop.reading.slope) / loop.reading.narrowest_state);
  narrow(m, loop.reading.slope);
  return m;
}

double describing_function(double amplitude, bool on_edge) {
  double sum = on_edge ? 0.5 : 0;
  for (double edge = on_edge ? 1 : 0.5; edge < amplitude; ++edge)
    sum += std::sqrt(1 - edge * edge / (amplitude * amplitude));
  return 4 / (std::numbers::pi * amplitude) * sum;
}

LimitCycle limit_cycle(const LoopMargins& m, double motion, double torque, double step,
                       const LoopReading& reading, double count, double lasting) {
  // Of rounding to states of one width: the largest N, of a sine across the edges of the narrowest.
  const double largest_on_count = 4 / (std::numbers::pi * reading.narrowest_state);
  LimitCycle c;
  // Errors before a factor are multiplied by it, and those behind it have its slope.
  const double factor = std::abs(reading.factor), slope = factor * reading.slope,
               of_position = std::max(1.0, factor) * reading.of_position;
  c.bound = motion * (lasting + of_position);
  if (slope * motion < 1) c.bound = std::min(c.bound, motion * lasting / (1 - slope * motion));
  c.torque_bound = torque * (lasting + std::min(of_position, slope * c.bound));
  c.torque_step = step * std::abs(reading.count) * count;
  c.on_count = !m.absolutely_stable &&
               std::ranges::any_of(m.critical_gains, [&](double gain) { return gain <= largest_on_count; });
  if (m.critical_frequency) {
    // Below one count the edge is a relay: N = 2/(pi A).
    c.on_edge = true;
    c.edge_amplitude = 2 * count * std::abs(reading.count / reading.factor) / (std::numbers::pi * m.gain);
    c.frequency = *m.critical_frequency;
  }
  return c;
}

double largest_step(const Filter& controller) {
  // Overshoot comes within some time constants of the slowest pole.
  constexpr double fewest = 64, most = 1e5, time_constants = 10;
  const double count = std::clamp(time_constants / (1 - poles_max_modulus(controller)), fewest, most);
  double step = 0, largest = 0;
  for (const double h : impulse_response(controller, static_cast<std::size_t>(count))) {
    step += h;
    largest = std::max(largest, std::abs(step));
  }
  return largest;
}

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
