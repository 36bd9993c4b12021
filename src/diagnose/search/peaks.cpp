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
  // Four cells or more in the period of the highest rate, in a number that has a fast transform: some parts
  // of a power of two, so that series of much the same length share one.
  const auto least = static_cast<std::size_t>(4 * std::max<Eigen::Index>(last, 4));
  std::size_t cells = std::bit_ceil(least);
  for (const std::size_t part : {20U, 24U, 25U, 27U, 30U})
    if (cells / 32 * part >= least) {
      cells = cells / 32 * part;
      break;
    }
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
  static thread_local Eigen::FFT<float> transform;  // keeps its roots of unity, a third of its time
  transform.SetFlag(Eigen::FFT<float>::HalfSpectrum);
  std::vector<std::complex<float>> spectrum;
  transform.fwd(spectrum, grid);
  std::vector<float> powers;
  for (Eigen::Index n = first; n <= last; ++n) {
    // Of the spline, the transform is sinc^4.
    const double u = std::numbers::pi * static_cast<double>(n) / static_cast<double>(cells);
    const double sinc = u > 0 ? std::sin(u) / u : 1, square = sinc * sinc, spline = square * square;
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

constexpr double most_rates = 100000;  ///< a limit of time: some 10 ms

}  // namespace

std::vector<double> strongest_rates(const Eigen::ArrayXd& scores, const Eigen::ArrayXd& arguments,
                                    const RateScan& scan, double& hypotheses) {
  hypotheses = 1;
  if (scores.size() < 8) return {};
  const double lowest = arguments.minCoeff(), range = arguments.maxCoeff() - lowest;
  if (!(range > 0)) return {};
  const double spacing = std::numbers::pi / range;
  const double first = std::max(1.0, std::ceil(scan.least / spacing)),
               last = std::min(first + most_rates, std::floor(scan.most / spacing));
  if (!(first <= last)) return {};
  hypotheses = std::max(1.0, (last - first) / 2);
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
    for (double step = spacing / 2; step > spacing / 400; step /= 2)
      for (const double candidate : {rate - step, rate + step})
        if (const double p = power_at(scores, argument, candidate); p > power) power = p, rate = candidate;
    found.push_back(rate);
    const auto near = std::min<std::ptrdiff_t>(2, strongest - powers.begin());
    const auto beyond = std::min<std::ptrdiff_t>(3, powers.end() - strongest);
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

/// Weighted means of consecutive samples, some 2000 of them: enough to find a shape among many.
class Means {
 public:
  Means(const Eigen::ArrayXd& residual, const Eigen::ArrayXd& weight, const Eigen::ArrayXd& argument) {
    constexpr Eigen::Index most = 2000;
    const Eigen::Index n = residual.size(), count = std::min(n, most);
    argument_.resize(count);
    weight_ = product_ = weight_from_ = product_from_ = Eigen::ArrayXd::Zero(count + 1);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Eigen::Index first = i * n / count, size = (i + 1) * n / count - first;
      weight_[i] = weight.segment(first, size).sum();
      argument_[i] = argument.segment(first, size).mean();
      product_[i] = (weight.segment(first, size) * residual.segment(first, size)).sum();
    }
    for (Eigen::Index i = count; i-- > 0;) {
      weight_from_[i] = weight_from_[i + 1] + weight_[i];
      product_from_[i] = product_from_[i + 1] + product_[i];
    }
  }

  /// Decrease of the weighted sum of squares, beside a constant, by a transition from 0 at `start` to 1 at
  /// `start` + `lasting` x `length`: only in between its shape is summed.
  /// @param shape  of the time since the start in units of the length
  template <typename Shape>
  double gain(double start, double length, double lasting, Shape shape) const {
    const auto from = [&](double time) {
      return std::lower_bound(argument_.begin(), argument_.end(), time) - argument_.begin();
    };
    const Eigen::Index end = from(start + lasting * length);
    double column = weight_from_[end], squares = column, product = product_from_[end];
    for (Eigen::Index k = from(start); k < end; ++k) {
      const double value = shape((argument_[k] - start) / length);
      column += value * weight_[k], squares += value * value * weight_[k], product += value * product_[k];
    }
    const double mean = column / weight_from_[0], power = squares - mean * column;
    return power > 0 ? std::pow(product - mean * product_from_[0], 2) / power : 0;
  }

 private:
  Eigen::ArrayXd argument_, weight_, product_;  ///< weight x residual
  Eigen::ArrayXd weight_from_, product_from_;   ///< sums from each on
};

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
  const Means m(residual, weight, time);
  const double duration = time[time.size() - 1] - time[0];
  const double shortest = 3 * duration / static_cast<double>(time.size()), longest = duration / 4;
  constexpr double settled = 37;  // e^-37 is below half a unit in the last place of 1
  std::tie(e.ramp_start, e.ramp_duration) = best_transition(
      e.time, shortest, longest,
      [&](double start, double length) { return m.gain(start, length, 1, [](double x) { return x; }); });
  std::tie(e.approach_start, e.time_constant) =
      best_transition(e.time, shortest, longest, [&](double start, double length) {
        return m.gain(start, length, settled, [](double x) { return 1 - std::exp(-x); });
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
  constexpr double none = 8.5;  // standard deviations beyond which it is below half a unit in the last place
  const double all = weights[bins], mean = sums[bins] / all;
  const auto bin_of = [&](double x) {
    return static_cast<Eigen::Index>(std::clamp((x - low) / range, 0.0, 1.0) * bins);
  };
  const auto gain_of = [&](double centre, double width) {
    if (!(width < range / 6)) return 0.0;
    const Eigen::Index first = bin_of(centre - none * width), count = bin_of(centre + none * width) - first;
    const Eigen::ArrayXd shape = (-0.5 * ((centres.segment(first, count) - centre) / width).square()).exp(),
                         inside = each.segment(first, count) * shape;
    const double squares = (inside * shape).sum(), sum = inside.sum(), power = squares - sum * sum / all;
    if (!(squares > least_inside && power > 0)) return 0.0;
    return std::pow((inside * (means.segment(first, count) - mean)).sum(), 2) / power;
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
