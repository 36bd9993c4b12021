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

/// The largest power of two up to `most` for which every stretch has a sample and the memory before the
/// stretches is not longer in total than the stretches themselves.
std::size_t stretches_of(std::size_t samples, std::size_t before, std::size_t most) {
  const std::size_t useful = std::min({most, samples, most_samples / std::max<std::size_t>(before, 1)});
  std::size_t stretches = 1;
  while (2 * stretches <= useful) stretches *= 2;
  return stretches;
}

/// r[n] from the longest lag down to 1, with leading zeros to a multiple of lags_at_once.
std::vector<double> weights_of(const Autocorrelation& a) {
  const std::size_t lags = (std::max<std::size_t>(a.r.size(), 2) - 1 + lags_at_once - 1) / lags_at_once;
  std::vector<double> weights(lags * lags_at_once, 0);
  for (std::size_t n = 1; n < a.r.size(); ++n) weights[weights.size() - n] = a.r[n];
  return weights;
}

/// path_sigma^2 over `count` positions from x, vectorized; the positions at all lags precede x in memory.
double power_along(const Autocorrelation& a, const std::vector<double>& weights, const double* x,
                   std::size_t count, const SimulationKernels& kernels) {
  const std::size_t before = a.r.size();
  // Beyond this work path_sigma evaluates a subset of the positions.
  constexpr double most_pairs = 2e8;
  if (static_cast<double>(before) * static_cast<double>(count) > most_pairs)
    return std::pow(path_sigma(a, std::span(x - before, before + count), before), 2);
  const double sum = kernels.losses(weights.data(), weights.size(), x, count);
  return std::max(0.0, a.dc_gain * a.dc_gain / 12 - sum / static_cast<double>(count));
}

/// Fractional counts of the encoders along a motion, evaluated window by window; samples that a window shares
/// with the previous one are kept.
class FractionalCounts {
 public:
  /// @param longest  window [samples]
  /// @param before   numbers that must precede it in memory, of any value
  FractionalCounts(const Transmission& transmission, const Motion& motion, double sample_rate, double start,
                   std::size_t longest, std::size_t before)
      : path_(motion),
        // Row-major, as the kernel expects.
        to_counts_((resolutions(transmission).cwiseInverse().asDiagonal() * inverse(transmission.coupling))
                       .transpose()),
        sample_rate_(sample_rate),
        start_(start),
        before_(before),
        capacity_(before + 2 * longest + batch_size),
        time_(batch_size),
        joints_(path_.joints() * batch_size),
        mixed_(path_.joints() * batch_size),
        rows_(path_.joints(), std::vector<double>(capacity_, 0)) {}

  /// Evaluates the samples first .. last - 1; windows are in increasing order.
  void evaluate(std::ptrdiff_t first, std::ptrdiff_t last) {
    if (first > end_ || end_ == begin_) begin_ = end_ = first;
    if (before_ + static_cast<std::size_t>(last - begin_) + batch_size > capacity_) discard_before(first);
    while (end_ < last) append();
  }

  /// Values of an encoder from an evaluated sample on.
  const double* from(std::size_t encoder, std::ptrdiff_t sample) const {
    return rows_[encoder].data() + before_ + (sample - begin_);
  }

 private:
  void discard_before(std::ptrdiff_t first) {
    for (std::size_t i = 0; i < rows_.size(); ++i)
      std::copy(from(i, first), from(i, end_), rows_[i].data() + before_);
    begin_ = first;
  }

  void append() {
    for (std::size_t i = 0; i < batch_size; ++i)
      time_[i] = start_ + static_cast<double>(end_ + static_cast<std::ptrdiff_t>(i)) / sample_rate_;
    for (std::size_t j = 0; j < path_.joints(); ++j)
      path_.positions(j, time_.data(), joints_.data() + j * batch_size);
    kernels_.mix(path_.joints(), to_counts_.data(), joints_.data(), mixed_.data());
    for (std::size_t i = 0; i < path_.joints(); ++i) {
      double* const row = mixed_.data() + i * batch_size;
      kernels_.subtract_nearest_integer(row);
      std::copy_n(row, batch_size, rows_[i].data() + before_ + (end_ - begin_));
    }
    end_ += batch_size;
  }

  MotionPath path_;
  Eigen::MatrixXd to_counts_;
  double sample_rate_, start_;
  std::size_t before_, capacity_;
  AlignedNumbers time_, joints_, mixed_;
  std::vector<std::vector<double>> rows_;  // of each encoder
  std::ptrdiff_t begin_ = 0, end_ = 0;     // the samples in the rows
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
  FractionalCounts counts(transmission, motion, sample_rate, start, before + longest, weights.size());
  const auto n = static_cast<Eigen::Index>(transmission.encoders.size());
  Eigen::MatrixXd power(static_cast<Eigen::Index>(stretches), n);
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t begin = s * whole / stretches, end = (s + 1) * whole / stretches;
    const std::size_t evaluated = std::min(end - begin, most_samples / stretches);
    // The middle of a stretch that is too long to be evaluated completely.
    const auto first = static_cast<std::ptrdiff_t>(begin + (end - begin - evaluated) / 2);
    counts.evaluate(first - static_cast<std::ptrdiff_t>(before),
                    first + static_cast<std::ptrdiff_t>(evaluated));
    for (Eigen::Index i = 0; i < n; ++i)
      power(static_cast<Eigen::Index>(s), i) =
          power_along(memory, weights, counts.from(static_cast<std::size_t>(i), first), evaluated,
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
