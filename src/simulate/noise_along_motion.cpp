#include "qerr/simulate/noise_along_motion.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "kernels.hpp"
#include "qerr/core/aligned.hpp"
#include "qerr/core/batch.hpp"

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

}  // namespace

Eigen::MatrixXd noise_power_along_motion(const Transmission& transmission, const Motion& motion,
                                         const Autocorrelation& memory, double sample_rate, double start,
                                         std::size_t most) {
  const MotionPath path(motion);
  const Eigen::MatrixXd to_quanta =
      resolutions(transmission).cwiseInverse().asDiagonal() * transmission.coupling.inverse();
  const auto whole =
      static_cast<std::size_t>(std::max(1.0, std::floor((motion.duration - start) * sample_rate)));
  const SimulationKernels& kernels = simulation_kernels(instruction_set());
  const Eigen::MatrixXd by_row = to_quanta.transpose();
  const AlignedNumbers time(batch_size), joints(path.joints() * batch_size),
      turned(path.joints() * batch_size);
  const std::size_t before = memory.r.size(), stretches = stretches_of(whole, before, most);
  const Eigen::Index n = to_quanta.rows();
  Eigen::MatrixXd power(static_cast<Eigen::Index>(stretches), n);
  const std::vector<double> weights = weights_of(memory);
  const std::size_t filled = weights.size() + 1 - before;  // before what the filter remembers
  std::vector<std::vector<double>> quanta(static_cast<std::size_t>(n));
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t begin = s * whole / stretches, end = (s + 1) * whole / stretches;
    const std::size_t looked_at = std::min(end - begin, most_samples / stretches);
    // In the middle of what is too long to be looked at in full.
    const std::size_t first = begin + (end - begin - looked_at) / 2;
    for (auto& row : quanta) row.resize(filled + before + looked_at);
    for (std::size_t k = 0; k < before + looked_at; k += batch_size) {
      for (std::size_t i = 0; i < batch_size; ++i)
        time[i] = start + (static_cast<double>(first + k + i) - static_cast<double>(before)) / sample_rate;
      for (std::size_t j = 0; j < path.joints(); ++j)
        path.positions(j, time.data(), joints.data() + j * batch_size);
      kernels.mix(path.joints(), by_row.data(), joints.data(), turned.data());
      const std::size_t count = std::min(batch_size, before + looked_at - k);
      for (std::size_t i = 0; i < path.joints(); ++i) {
        double* const row = turned.data() + i * batch_size;
        kernels.drop_whole(row);
        std::copy_n(row, count, quanta[i].data() + filled + k);
      }
    }
    for (Eigen::Index i = 0; i < n; ++i)
      power(static_cast<Eigen::Index>(s), i) = power_along(
          memory, weights, quanta[static_cast<std::size_t>(i)].data() + filled + before, looked_at, kernels);
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
