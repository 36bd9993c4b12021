#include "local_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace qerr {

bool is_uneven(const Eigen::ArrayXd& time) {
  const Eigen::Index n = time.size();
  if (n < 3) return false;
  const double interval = (time[n - 1] - time[0]) / static_cast<double>(n - 1);
  return ((time.tail(n - 1) - time.head(n - 1)) / interval - 1).abs().maxCoeff() > 0.05;
}

LocalFit local_fit(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x, Eigen::Index h) {
  const Eigen::Index n = x.size(), terms = h == 1 ? 2 : 4;
  const double interval = (time[n - 1] - time[0]) / static_cast<double>(n - 1);
  LocalFit fit{Eigen::ArrayXd(n), Eigen::ArrayXd(n), 0};
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index first = std::clamp<Eigen::Index>(k - h, 0, n - 2 * h - 1);
    // Distances in units of the window keep the powers alike.
    const double unit = interval * static_cast<double>(h);
    Eigen::Matrix4d moments = Eigen::Matrix4d::Identity();
    moments.topLeftCorner(terms, terms).setZero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (Eigen::Index i = first; i < first + 2 * h + 1; ++i) {
      const double d = (time[i] - time[k]) / unit;
      const Eigen::Vector4d powers =
          terms == 2 ? Eigen::Vector4d(1, d, 0, 0) : Eigen::Vector4d(1, d, d * d, d * d * d);
      moments += powers * powers.transpose();
      right += (x[i] - x[k]) * powers;
    }
    const Eigen::LLT<Eigen::Matrix4d> solver(moments);
    const Eigen::Vector4d fitted = solver.solve(right);
    fit.value[k] = x[k] + fitted[0];
    fit.slope[k] = fitted[1] / unit;
    fit.kept += (1 - solver.solve(Eigen::Vector4d(Eigen::Vector4d::UnitX()))[0]) / static_cast<double>(n);
  }
  return fit;
}

Eigen::ArrayXd roughness_at(const Eigen::ArrayXd& time, const Eigen::ArrayXd& x) {
  if (x.size() < 5) return {};
  const double interval = (time[x.size() - 1] - time[0]) / static_cast<double>(x.size() - 1);
  Eigen::ArrayXd rough = Eigen::ArrayXd::Zero(x.size() - 4);
  for (Eigen::Index k = 2; k + 2 < x.size(); ++k) {
    // The divided difference of fourth order, scaled so that white noise keeps its size.
    double sum = 0, squares = 0;
    for (Eigen::Index i = k - 2; i <= k + 2; ++i) {
      double weight = 1;
      for (Eigen::Index j = k - 2; j <= k + 2; ++j)
        if (j != i) weight *= interval / (time[i] - time[j]);
      sum += weight * (x[i] - x[k]);
      squares += weight * weight;
    }
    rough[k - 2] = sum / std::sqrt(squares);
  }
  return rough;
}

}  // namespace qerr
