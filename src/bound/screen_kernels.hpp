#pragma once

#include <cstddef>
#include <cstdint>

#include "lanes/batch.hpp"
#include "lanes/select_kernels.hpp"

namespace qerr {

// Included by kernel sources: without Eigen and containers.

/// Forms of one tile: as many as share what a core reads of the columns.
inline constexpr std::size_t forms_per_tile = 32;

/// Values of one form between two limits, found by `ScreenKernels::screen`.
struct ScreenBand {
  float lower = 0, upper = 0;  ///< lower <= value < upper
  std::uint32_t below = 0;     ///< number of values < lower
  std::uint32_t count = 0;     ///< of values in the band, also of those that were not kept
  std::uint32_t most = 0;      ///< that are kept; a kernel writes up to 64 numbers beyond
  float* values = nullptr;     ///< of the band, in the order of the configurations
  std::int32_t* at = nullptr;  ///< their places
};

/// Sums sum_k weight_k column_k, of columns and weights that are not negative, at many configurations for
/// many forms.
struct ScreenKernels {
  /// Values of one tile at `blocks` blocks of batch_size configurations.
  /// @param columns  [block][column][batch_size]
  /// @param weights  [form][column], forms_per_tile of them
  /// @param to       [form][block * batch_size]
  void (*values)(const float* columns, std::size_t blocks, std::size_t count, const float* weights,
                 float* to);

  /// Keeps the values of one tile that lie in its bands.
  /// @param bands    [form][band], each form's in ascending order, without overlap
  void (*screen)(const float* columns, std::size_t blocks, std::size_t count, const float* weights,
                 ScreenBand* bands, std::size_t bands_per_form);

  /// Number of values that are smaller than x.
  std::uint32_t (*below)(const float* values, std::uint32_t count, float x);

  /// Places of the values with lower <= value <= upper, in their order.
  /// @param at  of the values
  /// @param to  receives them, and up to 16 numbers beyond
  /// @returns their number
  std::uint32_t (*within)(const float* values, const std::int32_t* at, std::uint32_t count, float lower,
                          float upper, std::int32_t* to);

  /// Sum over the configurations of sqrt(sum_k weight_k columns_k^2 + added), in double.
  /// @param configurations  a multiple of batch_size
  /// @param partial  [batch_size]: receives a sum for each place in a batch
  void (*root_sums)(const double* const* columns, std::size_t count, const double* weights, double added,
                    std::size_t configurations, double* partial);
};

}  // namespace qerr
