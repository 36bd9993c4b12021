#pragma once

#include <cstddef>
#include <cstdint>

#include "bound/figure_layout.hpp"
#include "lanes/batch.hpp"

namespace qerr {

/// Consecutive configurations and their figures. Borrows the arrays for the duration of a call.
struct ConfigurationBatch {
  std::uint64_t first;    ///< index of the first one
  std::size_t count;      ///< up to batch_size
  const double* q;        ///< configuration c of joint i at q[i * batch_size + c] [rad or m]
  const double* figures;  ///< figure i of it at figures[i * batch_size + c]
  const FigureLayout& layout;
};

}  // namespace qerr
