#pragma once

#include <cstddef>
#include <cstdint>

#include "bound/figure_layout.hpp"
#include "lanes/batch.hpp"

namespace qerr {

/// Neighbouring configurations with their figures.
struct ConfigurationBatch {
  std::uint64_t first;    ///< index of the first one
  std::size_t count;      ///< up to batch_size
  const double* q;        ///< configuration c of joint i at q[i * batch_size + c] [rad or m]
  const double* figures;  ///< figure i of it at figures[i * batch_size + c]
  const FigureLayout& layout;
};

}  // namespace qerr
