#include "filter/norms/transient.hpp"

#include <algorithm>
#include <cmath>

#include "filter/run/cascade.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

std::vector<double> noise_transient(const Filter& filter, std::size_t count, std::size_t every) {
  std::vector<double> sigma(count);
  double sum = 0;
  const auto run = [&](auto cascade) {
    for (std::size_t k = 0; k < count * every; ++k) {
      const double h = static_cast<double>(cascade.step(k == 0 ? 1.0 : 0.0));
      sum += h * h;
      if (k % every == 0) sigma[k / every] = std::sqrt(sum);
    }
  };
  if (every == 1)
    run(Cascade<DoubleDouble>(filter));
  else
    run(Cascade<double>(filter));
  return sigma;
}

std::optional<double> noise_rise_time(const Filter& filter, double fraction) {
  const double level = std::pow(fraction * h2_norm(filter), 2);
  Cascade<double> cascade(filter);
  double sum = 0;
  for (std::size_t k = 0; k < std::size_t{1} << 22; ++k) {
    const double h = cascade.step(k == 0 ? 1.0 : 0.0);
    sum += h * h;
    if (sum >= level) return static_cast<double>(k) / filter.sample_rate;
  }
  return std::nullopt;
}

}  // namespace qerr
