#include "qerr/bound/derivative_error.hpp"

#include <cmath>

namespace qerr {

Bounds derivative_error(double half_width, double mean, double sigma, const Norms& norms) {
  return {norms.l1.upper * half_width + std::abs(norms.dc_gain) * std::abs(mean), norms.h2 * sigma};
}

}  // namespace qerr
