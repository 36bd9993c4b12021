#include "bound/proven/chain_bound.hpp"

#include <cmath>

#include "bound/proven/chain_form.hpp"
#include "bound/proven/position_sigma.hpp"

namespace qerr {

std::optional<double> chain_upper_bound(const OperationalModel& model, const std::vector<Limits>& ranges,
                                        const ChainBoundRequest& request, double known_lower, double gap) {
  const Coordinate c = coordinates_and_lengths(model).at(request.coordinate);
  const ChainForm form = chain_form(model, ranges);
  if (c != Coordinate::xyz || request.figure != ChainBoundRequest::Figure::sigma) return std::nullopt;
  double best = INFINITY;
  for (double cells = 12; cells <= 100; cells *= 2) {
    best = std::min(best, position_sigma_bound(form, cells));
    if (best <= known_lower * (1 + gap)) break;
  }
  return best;
}

}  // namespace qerr
