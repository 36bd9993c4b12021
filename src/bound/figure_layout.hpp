#pragma once

#include <cstddef>

namespace qerr {

/// Layout of the figures of a batch: figure i of configuration c at i * batch_size + c. Each member is the
/// index of the first coordinate's figure, the others follow. Figures that were not requested take no space.
struct FigureLayout {
  std::size_t coordinates = 0;  ///< all_signals of the model
  std::size_t worst_case = 0, sigma = 0, rigorous = 0;
  std::size_t filtered_worst = 0, filtered_sigma = 0, in_motion = 0;  ///< [filter][coordinate]
  std::size_t trace = 0;       ///< one: variance of the position, of all coordinates if there is no position
  std::size_t covariance = 0;  ///< [row][column <= row]
  std::size_t count = 0;       ///< of all figures
};

/// Layout of the sums over configurations. From `arms` on they are maxima.
struct SumLayout {
  std::size_t covariance = 0;                                  ///< [row][column <= row]
  std::size_t filtered = 0;                                    ///< the same behind every filter
  std::size_t variance_parts = 0, share = 0, worst_share = 0;  ///< [coordinate][encoder]
  std::size_t quantization_parts = 0;                          ///< [coordinate][encoder]; only beside sources
  std::size_t arms = 0;   ///< [encoder]: largest |dp/dx| of one axis [m/rad or 1]
  std::size_t pitch = 0;  ///< one: 1 - cos(pitch)
  std::size_t count = 0;
};

}  // namespace qerr
