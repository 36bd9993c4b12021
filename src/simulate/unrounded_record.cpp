#include "simulate/unrounded_record.hpp"

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

UnroundedRecord::UnroundedRecord(const Motion& motion, double rate, double settling) : motion_(motion) {
  const double ratio = motion.sample_rate / rate, whole = std::round(ratio);
  if (whole >= 1 && whole < 0x1p53 && std::abs(ratio - whole) <= 1e-9 * whole)
    every_ = static_cast<std::uint64_t>(whole);
  else
    motion_.sample_rate = rate;
  constexpr double most = 0x1p53;
  samples_ = static_cast<std::uint64_t>(
      std::clamp(std::floor(motion.duration * motion_.sample_rate + 0.5), 1.0, most));
  const std::uint64_t last = (samples_ - 1) / every_ * every_;
  settled_ = static_cast<std::uint64_t>(
      std::min(std::ceil(settling * motion_.sample_rate * (1 - 1e-12)), static_cast<double>(last)));
}

}  // namespace qerr
