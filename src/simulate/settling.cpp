#include "simulate/settling.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

namespace {

/// [s]. The factor 1.5 allows for the polynomial factors of repeated poles.
double settled_after(const Filter& filter) {
  const double modulus = poles_max_modulus(filter);
  const double decay = modulus > 0 ? std::log(1e-3) / std::log(modulus) : 0;
  const auto order = static_cast<double>(2 * filter.sections.size() + filter.taps.size());
  return (1.5 * decay + order) / filter.sample_rate;
}

}  // namespace

double settling_time(const Motion& motion, const std::vector<Filter>& filters) {
  if (motion.settling) return *motion.settling;
  double time = 0;
  for (const Filter& filter : filters) time = std::max(time, settled_after(filter));
  return std::min(time, 0.5 * motion.duration);
}

}  // namespace qerr
