#include "simulate/noise_along_motion.hpp"

#include <algorithm>
#include <cmath>

#include "core/solve.hpp"
#include "lanes/aligned.hpp"
#include "lanes/batch.hpp"
#include "simulate/kernels.hpp"
#include "simulate/motion_path.hpp"

namespace qerr {

namespace {

constexpr std::size_t most_samples = std::size_t{1} << 17;

/// The largest power of two up to `most` that leaves every stretch a sample, and no more path to be looked at
/// before the stretches than in them.
std::size_t stretches_of(std::size_t samples, std::size_t before, std::size_t most) {
  const std::size_t useful = std::min({most, samples, most_samples / std::max<std::size_t>(before, 1)});
  std::size_t stretches = 1;
  while (2 * stretches <= useful) stretches *= 2;
  return stretches;
}

/// r[n] from the longest lag down to 1, filled up with zeros before the longest one.
std::vector<double> weights_of(const Autocorrelation& a) {
  const std::size_t lags = (std::max<std::size_t>(a.r.size(), 2) - 1 + lags_at_once - 1) / lags_at_once;
  std::vector<double> weights(lags * lags_at_once, 0);
  for (std::size_t n = 1; n < a.r.size(); ++n) weights[weights.size() - n] = a.r[n];
  return weights;
}

/// path_sigma^2, in lanes, over `count` positions from x; before it stand those that the weights reach.
double power_along(const Autocorrelation& a, const std::vector<double>& weights, const double* x,
                   std::size_t count, const SimulationKernels& kernels) {
  const std::size_t before = a.r.size();
  // Longer work is thinned out there.
  constexpr double most_pairs = 2e8;
  if (static_cast<double>(before) * static_cast<double>(count) > most_pairs)
    return std::pow(path_sigma(a, std::span(x - before, before + count), before), 2);
  const double sum = kernels.losses(weights.data(), weights.size(), x, count);
  return std::max(0.0, a.dc_gain * a.dc_gain / 12 - sum / static_cast<double>(count));
}

/// The encoders along a motion, in counts less whole ones, where it is looked at: from window to window, and
/// what the next one shares with the last is kept.
class Counts {
 public:
  /// @param longest  window [samples]
  /// @param before   how many numbers, whatever they are, must stand before it
  Counts(const Transmission& transmission, const Motion& motion, double sample_rate, double start,
         std::size_t longest, std::size_t before)
      : path_(motion),
        // Row by row, as the kernel wants it.
        to_counts_((resolutions(transmission).cwiseInverse().asDiagonal() * inverse(transmission.coupling))
                       .transpose()),
        sample_rate_(sample_rate),
        start_(start),
        before_(before),
        room_(before + 2 * longest + batch_size),
        time_(batch_size),
        joints_(path_.joints() * batch_size),
        turned_(path_.joints() * batch_size),
        rows_(path_.joints(), std::vector<double>(room_, 0)) {}

  /// Makes the samples first .. last - 1 known; they come in order.
  void look_at(std::ptrdiff_t first, std::ptrdiff_t last) {
    if (first > end_ || end_ == begin_) begin_ = end_ = first;
    if (before_ + static_cast<std::size_t>(last - begin_) + batch_size > room_) forget(first);
    while (end_ < last) append();
  }

  /// Of an encoder, from a sample that has been looked at.
  const double* from(std::size_t encoder, std::ptrdiff_t sample) const {
    return rows_[encoder].data() + before_ + (sample - begin_);
  }

 private:
  void forget(std::ptrdiff_t first) {
    for (std::size_t i = 0; i < rows_.size(); ++i)
      std::copy(from(i, first), from(i, end_), rows_[i].data() + before_);
    begin_ = first;
  }

  void append() {
    for (std::size_t i = 0; i < batch_size; ++i)
      time_[i] = start_ + static_cast<double>(end_ + static_cast<std::ptrdiff_t>(i)) / sample_rate_;
    for (std::size_t j = 0; j < path_.joints(); ++j)
      path_.positions(j, time_.data(), joints_.data() + j * batch_size);
    kernels_.mix(path_.joints(), to_counts_.data(), joints_.data(), turned_.data());
    for (std::size_t i = 0; i < path_.joints(); ++i) {
      double* const row = turned_.data() + i * batch_size;
      kernels_.drop_whole(row);
      std::copy_n(row, batch_size, rows_[i].data() + before_ + (end_ - begin_));
    }
    end_ += batch_size;
  }

  MotionPath path_;
  Eigen::MatrixXd to_counts_;
  double sample_rate_, start_;
  std::size_t before_, room_;
  AlignedNumbers time_, joints_, turned_;
  std::vector<std::vector<double>> rows_;  // of each encoder
  std::ptrdiff_t begin_ = 0, end_ = 0;     // the samples that they hold
  const SimulationKernels& kernels_ = select_kernels<SimulationKernels>(instruction_set());
};

}  // namespace

Eigen::MatrixXd noise_power_along_motion(const Transmission& transmission, const Motion& motion,
                                         const Autocorrelation& memory, double sample_rate, double start,
                                         std::size_t most) {
  const auto whole =
      static_cast<std::size_t>(std::max(1.0, std::floor((motion.duration - start) * sample_rate)));
  const std::vector<double> weights = weights_of(memory);
  const std::size_t before = memory.r.size(), stretches = stretches_of(whole, before, most);
  const std::size_t longest = std::min(whole / stretches + 1, most_samples / stretches);
  Counts counts(transmission, motion, sample_rate, start, before + longest, weights.size());
  const auto n = static_cast<Eigen::Index>(transmission.encoders.size());
  Eigen::MatrixXd power(static_cast<Eigen::Index>(stretches), n);
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t begin = s * whole / stretches, end = (s + 1) * whole / stretches;
    const std::size_t looked_at = std::min(end - begin, most_samples / stretches);
    // In the middle of what is too long to be looked at in full.
    const auto first = static_cast<std::ptrdiff_t>(begin + (end - begin - looked_at) / 2);
    counts.look_at(first - static_cast<std::ptrdiff_t>(before),
                   first + static_cast<std::ptrdiff_t>(looked_at));
    for (Eigen::Index i = 0; i < n; ++i)
      power(static_cast<Eigen::Index>(s), i) =
          power_along(memory, weights, counts.from(static_cast<std::size_t>(i), first), looked_at,
                      select_kernels<SimulationKernels>(instruction_set()));
  }
  return power;
}

Eigen::VectorXd noise_along_motion(const Transmission& transmission, const Motion& motion,
                                   const Autocorrelation& memory, double sample_rate, double start) {
  return noise_power_along_motion(transmission, motion, memory, sample_rate, start, 512)
      .colwise()
      .mean()
      .cwiseSqrt();
}

}  // namespace qerr
