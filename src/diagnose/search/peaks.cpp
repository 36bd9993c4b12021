#include "diagnose/search/peaks.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <tuple>
#include <unsupported/Eigen/FFT>
#include <utility>

#include "diagnose/surrogates/residual_kernels.hpp"

namespace qerr {

std::vector<float> periodogram(const Eigen::ArrayXd& score, const Eigen::ArrayXd& argument, double spacing,
                               Eigen::Index first, Eigen::Index last) {
  // Four cells or more in the period of the highest rate.
  const auto cells = std::bit_ceil(static_cast<std::size_t>(4 * std::max<Eigen::Index>(last, 4)));
  const double cells_per_unit = spacing * static_cast<double>(cells) / (2 * std::numbers::pi);
  std::vector<float> grid(cells, 0.0F);
  for (Eigen::Index k = 0; k < score.size(); ++k) {
    const double place = argument[k] * cells_per_unit, cell = std::floor(place), x = place - cell;
    const double y = 1 - x;
    // The cubic B-spline at the four cells about the place, the second of which is the one at or before it.
    const double weights[4] = {y * y * y / 6, (4 - 6 * x * x + 3 * x * x * x) / 6,
                               (4 - 6 * y * y + 3 * y * y * y) / 6, x * x * x / 6};
    for (std::size_t i = 0; i < 4; ++i)
      grid[(static_cast<std::size_t>(cell) + i + cells - 1) % cells] +=
          static_cast<float>(score[k] * weights[i]);
  }
  Eigen::FFT<float> transform;
  transform.SetFlag(Eigen::FFT<float>::HalfSpectrum);
  std::vector<std::complex<float>> spectrum;
  transform.fwd(spectrum, grid);
  std::vector<float> powers;
  for (Eigen::Index n = first; n <= last; ++n) {
    // Of the spline, the transform is sinc^4.
    const double u = std::numbers::pi * static_cast<double>(n) / static_cast<double>(cells);
    const double spline = u > 0 ? std::pow(std::sin(u) / u, 4) : 1;
    powers.push_back(std::norm(spectrum[static_cast<std::size_t>(n)]) / static_cast<float>(spline * spline));
  }
  return powers;
}

double power_at(const Eigen::ArrayXd& score, const Eigen::ArrayXd& argument, double rate) {
  const Eigen::ArrayXd angle = rate * argument;
  Eigen::ArrayXd sine(angle.size()), cosine(angle.size());
  select_kernels<ResidualKernels>(instruction_set())
      .sines(angle.data(), static_cast<std::size_t>(angle.size()), sine.data(), cosine.data());
  return std::pow((score * cosine).sum(), 2) + std::pow((score * sine).sum(), 2);
}

namespace {

constexpr double most_rates = 200000;  ///< a limit of time: some 20 ms

}  // namespace

std::vector<double> strongest_rates(const Eigen::ArrayXd& scores, const Eigen::ArrayXd& arguments,
                                    const RateScan& scan, double& hypotheses) {
  hypotheses = 1;
  if (scores.size() < 8) return {};
  const double lowest = arguments.minCoeff(), range = arguments.maxCoeff() - lowest;
  if (!(range > 0)) return {};
  const double spacing = 0.5 * std::numbers::pi / range;
  const double first = std::max(1.0, std::ceil(scan.least / spacing)),
               last = std::min(first + most_rates, std::floor(scan.most / spacing));
  if (!(first <= last)) return {};
  hypotheses = std::max(1.0, (last - first) / 4);
  // The power does not depend on the origin of the argument; a small argument has an accurate sine.
  const Eigen::ArrayXd argument = arguments - lowest;
  std::vector<float> powers = periodogram(scores, argument, spacing, static_cast<Eigen::Index>(first),
                                          static_cast<Eigen::Index>(last));
  std::vector<double> found;
  while (static_cast<Eigen::Index>(found.size()) < scan.most_peaks) {
    const auto strongest = std::max_element(powers.begin(), powers.end());
    if (!(*strongest > 0)) break;
    double rate = (first + static_cast<double>(strongest - powers.begin())) * spacing;
    double power = power_at(scores, argument, rate);
    for (double step = spacing / 2; step > spacing / 200; step /= 2)
      for (const double candidate : {rate - step, rate + step})
        if (const double p = power_at(scores, argument, candidate); p > power) power = p, rate = candidate;
    found.push_back(rate);
    const auto near = std::min<std::ptrdiff_t>(4, strongest - powers.begin());
    const auto beyond = std::min<std::ptrdiff_t>(5, powers.end() - strongest);
    std::fill(strongest - near, strongest + beyond, 0.0F);
  }
  return found;
}

namespace {

/// First row of the strongest step; 0 if the record is too short.
Eigen::Index strongest_step(const Eigen::ArrayXd& residual, const Eigen::ArrayXd& weight) {
  constexpr Eigen::Index edge = 8;  // least number of rows on either side of a step
  const Eigen::Index n = residual.size();
  const double all = (residual * weight).sum(), total = weight.sum();
  double after = 0, weight_after = 0, best = 0;
  Eigen::Index first = 0;
  for (Eigen::Index k = n; k-- > edge;) {
    after += residual[k] * weight[k];
    weight_after += weight[k];
    if (k + edge > n) continue;
    const double part = weight_after / total, information = weight_after * (1 - part);
    const double gain = information > 0 ? std::pow(after - part * all, 2) / information : 0;
    if (gain > best) best = gain, first = k;
  }
  return first;
}

/// Decrease of the weighted sum of squares by a column beside a constant.
double gain_beside_constant(const Eigen::ArrayXd& residual, const Eigen::ArrayXd& weight,
                            const Eigen::ArrayXd& column) {
  const double all = weight.sum(), mean = (column * weight).sum() / all;
  const Eigen::ArrayXd centred = column - mean;
  const double power = (centred.square() * weight).sum();
  return power > 0 ? std::pow((centred * weight * residual).sum(), 2) / power : 0;
}

/// Weighted means of consecutive samples, some 2000 of them: enough to find a shape among many.
struct Means {
  Eigen::ArrayXd residual, weight, argument;
};

Means means_of(const Eigen::ArrayXd& residual, const Eigen::ArrayXd& weight, const Eigen::ArrayXd& argument) {
  constexpr Eigen::Index most = 2000;
  const Eigen::Index n = residual.size(), count = std::min(n, most);
  Means m{Eigen::ArrayXd::Zero(count), Eigen::ArrayXd::Zero(count), Eigen::ArrayXd::Zero(count)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index first = i * n / count, size = (i + 1) * n / count - first;
    const auto w = weight.segment(first, size);
    m.weight[i] = w.sum();
    m.argument[i] = argument.segment(first, size).mean();
    if (m.weight[i] > 0) m.residual[i] = (w * residual.segment(first, size)).sum() / m.weight[i];
  }
  return m;
}

/// Start and length of the transition with the largest gain: a grid about the step that is refined by halves.
template <typename Transition>
std::pair<double, double> best_transition(double time, double shortest, double longest, Transition gain) {
  double start = time, length = shortest, best = 0;
  for (double trial = shortest; trial <= longest && std::isfinite(trial); trial *= 1.5)
    for (const double before : {0.0, 0.25, 0.5, 0.75, 1.0})
      if (const double g = gain(time - before * trial, trial); g > best)
        best = g, start = time - before * trial, length = trial;
  for (double step = 0.25; step > 0.002; step /= 2) {
    bool better = true;
    for (int move = 0; better && move < most_moves_of_step; ++move) {
      better = false;
      const double from = start, of = length;
      for (const double shift : {-step, 0.0, step})
        for (const double factor : {1 / (1 + step), 1.0, 1 + step}) {
          const double next = from + shift * of, lasting = std::max(shortest, of * factor);
          if (const double g = gain(next, lasting); g > best * (1 + 1e-9))
            best = g, start = next, length = lasting, better = true;
        }
    }
  }
  return {start, length};
}

}  // namespace

Event strongest_event(const Eigen::ArrayXd& residual, const Eigen::ArrayXd& weight,
                      const Eigen::ArrayXd& time) {
  Event e;
  const Eigen::Index first = strongest_step(residual, weight);
  if (first == 0) return e;
  e.hypotheses = static_cast<double>(residual.size());
  e.time = 0.5 * (time[first] + time[first - 1]);
  return e;
}

void find_transitions(Event& e, const Eigen::ArrayXd& residual, const Eigen::ArrayXd& weight,
                      const Eigen::ArrayXd& time) {
  const Means m = means_of(residual, weight, time);
  const double duration = time[time.size() - 1] - time[0];
  const double shortest = 3 * duration / static_cast<double>(time.size()), longest = duration / 4;
  std::tie(e.ramp_start, e.ramp_duration) =
      best_transition(e.time, shortest, longest, [&](double start, double length) {
        return gain_beside_constant(m.residual, m.weight, ((m.argument - start) / length).max(0.0).min(1.0));
      });
  std::tie(e.approach_start,
           e.time_constant) = best_transition(e.time, shortest, longest, [&](double start, double length) {
    return gain_beside_constant(m.residual, m.weight, 1 - (-(m.argument - start).max(0.0) / length).exp());
  });
}

Bump strongest_bump(const Eigen::ArrayXd& residual, const Eigen::ArrayXd& weight,
                    const Eigen::ArrayXd& position) {
  constexpr Eigen::Index bins = 1024;
  const double low = position.minCoeff(), range = position.maxCoeff() - low;
  Bump best;
  if (!(range > 0) || residual.size() < 64) return best;
  Eigen::ArrayXd sums = Eigen::ArrayXd::Zero(bins + 1), weights = sums;
  for (Eigen::Index k = 0; k < residual.size(); ++k) {
    const auto bin = std::min(bins - 1, static_cast<Eigen::Index>((position[k] - low) / range * bins));
    sums[bin + 1] += residual[k] * weight[k];
    weights[bin + 1] += weight[k];
  }
  for (Eigen::Index i = 1; i <= bins; ++i) sums[i] += sums[i - 1], weights[i] += weights[i - 1];
  double gain = 0;
  for (Eigen::Index width = 2; width <= bins / 8; width *= 2)
    for (Eigen::Index i = 0; i + width <= bins; ++i) {
      const double inside = weights[i + width] - weights[i];
      if (inside <= 0) continue;
      if (const double here = std::pow(sums[i + width] - sums[i], 2) / inside; here > gain) {
        gain = here;
        best.position = low + range * (static_cast<double>(i) + 0.5 * static_cast<double>(width)) / bins;
        // A Gaussian of standard deviation s has the area of a window of 2.5 s.
        best.width = range * static_cast<double>(width) / bins / 2.5;
      }
    }
  best.hypotheses = 2 * bins;
  // The shape is a Gaussian: position and width by a grid that is refined by halves.
  const Eigen::ArrayXd each = weights.tail(bins) - weights.head(bins);
  const Eigen::ArrayXd means = (each > 0).select((sums.tail(bins) - sums.head(bins)) / each.max(1e-300), 0.0);
  const Eigen::ArrayXd centres =
      low + range / bins * Eigen::ArrayXd::LinSpaced(bins, 0.5, static_cast<double>(bins) - 0.5);
  // A bump between the samples would have any height, and a wide one is a curve.
  const double least_inside = 8 * weight.sum() / static_cast<double>(weight.size());
  const auto gain_of = [&](double centre, double width) {
    const Eigen::ArrayXd shape = (-0.5 * ((centres - centre) / width).square()).exp();
    const bool is_bump = width < range / 6 && (each * shape.square()).sum() > least_inside;
    return is_bump ? gain_beside_constant(means, each, shape) : 0;
  };
  gain = gain_of(best.position, best.width);
  if (gain == 0) return {};
  for (double step = 0.5; best.width > 0 && step > 0.01; step /= 2) {
    bool better = true;
    for (int move = 0; better && move < most_moves_of_step; ++move) {
      better = false;
      const Bump from = best;
      for (const double shift : {-step, 0.0, step})
        for (const double factor : {1 / (1 + step), 1.0, 1 + step})
          if (const double g = gain_of(from.position + shift * from.width, from.width * factor);
              g > gain * (1 + 1e-9))
            gain = g, best.position = from.position + shift * from.width, best.width = from.width * factor,
            better = true;
    }
  }
  return best;
}

}  // namespace qerr
