#include "bound/proven/chain_bound.hpp"

namespace qerr {

std::optional<double> chain_upper_bound(const OperationalModel&, const std::vector<Limits>&,
                                        const ChainBoundRequest&, double, double) {
  return std::nullopt;
}

}  // namespace qerr
