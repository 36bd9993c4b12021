#pragma once

#include <cstddef>
#include <vector>

#include "bound/figure_layout.hpp"
#include "qerr/bound/proven_maximum.hpp"
#include "qerr/input/spec.hpp"

namespace qerr {

/// Where a figure stands in a batch, and the norm by which it is multiplied.
struct FigureColumn {
  std::size_t figure;
  double factor;
};

/// @pre the analysis has the figure
FigureColumn figure_column(const ProvenFigure&, const std::vector<NamedFilter>&, const FigureLayout&);

}  // namespace qerr
