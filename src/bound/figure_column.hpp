#pragma once

#include <cstddef>
#include <vector>

#include "bound/figure_layout.hpp"
#include "qerr/bound/figure.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

/// Where a figure stands in a batch, and the norm by which it is multiplied.
struct FigureColumn {
  std::size_t figure;
  double factor;
};

/// @pre the batch has the figure
FigureColumn figure_column(const Figure&, const std::vector<Norms>& filters, const FigureLayout&);

}  // namespace qerr
