#include "qerr/filter/transient.hpp"

#include <algorithm>
#include <cmath>

#include "qerr/filter/norms.hpp"

namespace qerr {

std::vector<double> noise_transient(const Filter& filter, std::size_t count) {
  std::vector<double> sigma = impulse_response(filter, count);
  double sum = 0;
  for (double& s : sigma) {
    sum += s * s;
    s = std::sqrt(sum);
  }
  return sigma;
}

std::optional<double> noise_rise_time(const Filter& filter, double fraction) {
  const double level = fraction * h2_norm(filter);
  for (std::size_t count = 1024; count <= std::size_t{1} << 22; count *= 4) {
    const std::vector<double> sigma = noise_transient(filter, count);
    const auto reached = std::lower_bound(sigma.begin(), sigma.end(), level);
    if (reached != sigma.end()) return static_cast<double>(reached - sigma.begin()) / filter.sample_rate;
  }
  return std::nullopt;
}

}  // namespace qerr
