#include "simulate/unrounded_record.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

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
