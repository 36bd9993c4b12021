#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bound/kernels.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/figure.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

/// Consecutive configurations and their figures. Borrows the arrays for the duration of a call.
struct ConfigurationBatch {
  std::uint64_t first;    ///< index of the first one
  std::size_t count;      ///< up to batch_size
  const double* q;        ///< configuration c of joint i at q[i * batch_size + c] [rad or m]
  const double* figures;  ///< figure i of it at figures[i * batch_size + c]
  const FigureLayout& layout;
};

/// Where a figure stands in a batch, and the norm by which it is multiplied.
struct FigureColumn {
  std::size_t figure;
  double factor;
};

/// @pre the batch has the figure
FigureColumn figure_column(const Figure&, const std::vector<Norms>& filters, const FigureLayout&);

}  // namespace qerr
