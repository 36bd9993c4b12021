#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "bound/proven/chain_bound.hpp"
#include "bound/signal_errors.hpp"
#include "support/random_chain.hpp"

namespace qerr::testing {

/// The figure at a configuration, by the scalar bounds.
/// @pre a length's components are coordinates of the model, and its sources do not displace origins
inline double figure_at(const OperationalModel& m, const Figure& request, const Eigen::VectorXd& q) {
  const OperationalError e = operational_error(m, q);
  const bool worst = !is_sigma(request.bound);
  const auto index = static_cast<Eigen::Index>(request.signal);
  if (index < e.sigma.size()) return worst ? e.worst_case[index] : e.sigma[index];
  const Coordinate first = first_component(m.lengths[request.signal - m.coordinates.size()]);
  Eigen::Vector3d sigma, mean;
  Eigen::Matrix3Xd corners(3, e.weighted.cols());
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto c = static_cast<Coordinate>(static_cast<Eigen::Index>(first) + k);
    const Eigen::Index row = std::find(m.coordinates.begin(), m.coordinates.end(), c) - m.coordinates.begin();
    sigma[k] = e.sigma[row];
    mean[k] = e.mean[row];
    corners.row(k) = 0.5 * e.weighted.row(row);
  }
  return worst ? largest_corner(mean, corners) : sigma.norm();
}

/// The largest figure that a search finds: random samples, and from the best of them coordinate ascent by
/// samples of each joint's range and successive refinement.
inline double largest_figure(const OperationalModel& m, const std::vector<Limits>& ranges,
                             const Figure& request, std::size_t samples, std::uint64_t seed) {
  Dice dice(seed);
  const auto value = [&](const Eigen::VectorXd& q) { return figure_at(m, request, q); };
  std::vector<std::pair<double, Eigen::VectorXd>> found;
  for (std::size_t i = 0; i < samples; ++i) {
    Eigen::VectorXd q(static_cast<Eigen::Index>(ranges.size()));
    for (Eigen::Index k = 0; k < q.size(); ++k)
      q[k] =
          dice.between(ranges[static_cast<std::size_t>(k)].lower, ranges[static_cast<std::size_t>(k)].upper);
    found.emplace_back(value(q), q);
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  found.resize(std::min<std::size_t>(found.size(), 12));
  double largest = 0;
  for (auto& [best, q] : found) {
    for (double before = -1; best > before * (1 + 1e-6);) {
      before = best;
      for (Eigen::Index k = 0; k < q.size(); ++k) {
        double low = ranges[static_cast<std::size_t>(k)].lower,
               high = ranges[static_cast<std::size_t>(k)].upper;
        double at = q[k];
        for (int round = 0; round < 5; ++round) {
          const double step = (high - low) / 16;
          for (int i = 0; i <= 16; ++i) {
            q[k] = i == 16 ? high : low + i * step;
            if (const double v = value(q); v > best) best = v, at = q[k];
          }
          low = std::max(low, at - step), high = std::min(high, at + step);
        }
        q[k] = at;
      }
    }
    largest = std::max(largest, best);
  }
  return largest;
}

}  // namespace qerr::testing
