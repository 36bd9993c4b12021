#pragma once

#include <cstddef>

namespace qerr {

/// Where the figures of a batch stand: figure i of configuration c at i * batch_size + c. The numbers are
/// those of the first coordinate's; the others follow. What is not asked for has no place.
struct FigureLayout {
  std::size_t coordinates = 0;
  std::size_t worst_case = 0, sigma = 0, rigorous = 0;
  std::size_t filtered_worst = 0, filtered_sigma = 0, in_motion = 0;  ///< [filter][coordinate]
  std::size_t trace = 0;  ///< one: the position's variance, of all coordinates where there is no position
  std::size_t covariance = 0;  ///< [row][column <= row]
  std::size_t count = 0;       ///< of all
};

/// Where the sums over configurations stand. Those from `arms` on are maxima.
struct SumLayout {
  std::size_t covariance = 0;                                  ///< [row][column <= row]
  std::size_t filtered = 0;                                    ///< the same behind every filter
  std::size_t variance_parts = 0, share = 0, worst_share = 0;  ///< [coordinate][encoder]
  std::size_t arms = 0;   ///< [encoder]: |dp/dx| of one axis [m/rad or 1]
  std::size_t pitch = 0;  ///< one: 1 - cosine of the pitch
  std::size_t count = 0;
};

}  // namespace qerr
