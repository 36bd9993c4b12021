#include "qerr/bound/derivative_error.hpp"

#include <cmath>

namespace qerr {

Bounds derivative_error(double half_width, double mean, double sigma, const Norms& norms) {
  return {norms.l1.upper * half_width + std::abs(norms.dc_gain) * std::abs(mean), norms.h2 * sigma};
}

Bounds derivative_error(const OperationalError& e, Eigen::Index i, const Norms& norms,
                        const Eigen::VectorXd& ratios) {
  Bounds b = derivative_error(e.half_width[i], e.mean[i], e.sigma[i], norms);
  if (ratios.size() == 0 || !std::isfinite(e.sigma[i])) return b;
  const double quantization = norms.h2 * e.weighted.row(i).norm() / std::sqrt(12.0);
  b.sigma = std::hypot(quantization, e.added_sigma.row(i).cwiseProduct(ratios.transpose()).norm());
  return b;
}

}  // namespace qerr
