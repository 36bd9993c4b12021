#include "qerr/simulate/noise_along_motion.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace qerr {

namespace {

constexpr std::size_t most_samples = std::size_t{1} << 17;

}  // namespace

Eigen::VectorXd noise_along_motion(const Transmission& transmission, const Motion& motion,
                                   const Autocorrelation& memory, double sample_rate, double start) {
  const MotionPath path(motion);
  const Eigen::MatrixXd to_quanta =
      resolutions(transmission).cwiseInverse().asDiagonal() * transmission.coupling.inverse();
  const auto whole =
      static_cast<std::size_t>(std::max(1.0, std::floor((motion.duration - start) * sample_rate)));
  const std::size_t before = memory.r.size();
  const std::size_t stretch =
      whole <= most_samples ? whole : std::min(whole, std::max<std::size_t>(before, 1 << 14));
  const std::size_t stretches = whole <= most_samples ? 1 : std::max<std::size_t>(1, most_samples / stretch);
  const Eigen::Index n = to_quanta.rows();
  Eigen::VectorXd power = Eigen::VectorXd::Zero(n);
  std::vector<std::vector<double>> quanta(static_cast<std::size_t>(n), std::vector<double>(before + stretch));
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t first = stretches == 1 ? 0 : s * (whole - stretch) / (stretches - 1);
    for (std::size_t k = 0; k < before + stretch; ++k) {
      const double sample = static_cast<double>(first + k) - static_cast<double>(before);
      const Eigen::VectorXd x = to_quanta * path.position(start + sample / sample_rate);
      for (Eigen::Index i = 0; i < n; ++i) quanta[static_cast<std::size_t>(i)][k] = x[i];
    }
    for (Eigen::Index i = 0; i < n; ++i)
      power[i] += std::pow(path_sigma(memory, quanta[static_cast<std::size_t>(i)], before), 2);
  }
  return (power / static_cast<double>(stretches)).cwiseSqrt();
}

}  // namespace qerr
