#include "bound/figure_column.hpp"

namespace qerr {

FigureColumn figure_column(const Figure& f, const std::vector<Norms>& filters, const FigureLayout& at) {
  const std::size_t c = f.signal;
  if (f.filter < 0)
    return {(f.bound == Bound::worst_case            ? at.worst_case
             : f.bound == Bound::worst_case_rigorous ? at.rigorous
                                                     : at.sigma) +
                c,
            1};
  const auto filter = static_cast<std::size_t>(f.filter);
  const std::size_t behind = filter * at.coordinates + c;
  const Norms& norms = filters[filter];
  // Of other errors there is one more filter, behind which is nothing but quantization.
  if (f.bound == Bound::sigma_quantization && at.in_motion > at.filtered_sigma)
    return {at.filtered_sigma + filters.size() * at.coordinates + c, norms.h2};
  if (f.bound == Bound::sigma_in_motion) return {at.in_motion + behind, 1};
  if (f.bound == Bound::worst_case)
    return at.filtered_sigma > at.filtered_worst ? FigureColumn{at.filtered_worst + behind, 1}
                                                 : FigureColumn{at.worst_case + c, norms.l1.upper};
  return at.in_motion > at.filtered_sigma ? FigureColumn{at.filtered_sigma + behind, 1}
                                          : FigureColumn{at.sigma + c, norms.h2};
}

}  // namespace qerr
