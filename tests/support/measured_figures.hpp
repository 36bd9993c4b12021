#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "qerr/bound/figure.hpp"
#include "qerr/filter/norms.hpp"
#include "support/design_filter.hpp"
#include "support/measured.hpp"
#include "support/random_model.hpp"

/// Models of all kinds, and their figures as rows of tests/golden/workspace_figures.csv.
namespace qerr::testing {

/// The figures of one model by name. 1e-8 of each: another compiler rounds the last digits otherwise.
class MeasuredFigures {
 public:
  explicit MeasuredFigures(std::string model) : model_(std::move(model)) {}

  void operator()(const std::string& figure, double value) const {
    static const Measured measured("workspace_figures.csv", 1e-8);
    // Below are rounding errors of coordinates that do not move.
    measured.expect(model_ + ',' + figure, std::abs(value) < 1e-13 ? 0 : value);
  }
  void operator()(const std::string& figure, const Statistic& s) const {
    for (const StatisticKind& kind : statistic_kinds())
      (*this)(figure + ' ' + std::string(kind.name), s.*kind.value);
    if (s.max < 1e-13 || !std::isfinite(s.max)) return;
    double place = 0, weight = 1;
    for (const double q : s.at_max) place += q * std::exchange(weight, 0.7 * weight);
    (*this)(figure + " at_max", place);
  }
  void operator()(const std::string& figure, const Eigen::MatrixXd& m) const {
    for (Eigen::Index r = 0; r < m.rows(); ++r)
      for (Eigen::Index c = 0; c < m.cols(); ++c)
        (*this)(figure + ' ' + std::to_string(r) + (m.cols() > 1 ? ' ' + std::to_string(c) : ""), m(r, c));
  }
  /// Sigmas and correlations.
  void covariance(const std::string& figure, const Eigen::MatrixXd& m) const {
    for (Eigen::Index r = 0; r < m.rows(); ++r)
      for (Eigen::Index c = 0; c <= r; ++c) {
        const double size = std::sqrt(m(r, r) * m(c, c));
        if (size < 1e-26 || !std::isfinite(size)) continue;
        (*this)(figure + ' ' + std::to_string(r) + ' ' + std::to_string(c),
                r == c ? std::sqrt(m(r, r)) : m(r, c) / size);
      }
  }

 private:
  std::string model_;
};

inline SignalMoments moments_of_motion(Dice& dice, Eigen::Index n, double size) {
  SignalMoments m{Eigen::VectorXd::Zero(n), dice.vector(n, 0.5 * size, size), Eigen::MatrixXd::Zero(n, n)};
  m.covariance.diagonal() = dice.vector(n, 0.1, 0.3) * size * size;
  return m;
}

inline std::vector<Norms> two_filters() { return {norms(difference_filter(1000, 1)), norms(cascade(0, 2))}; }

/// Chains of all kinds with encoders, sources, errors along a motion, lengths: of each a part of the models.
inline OperationalModel model_of_figures(Dice& dice, std::uint64_t seed) {
  const double square[]{0, 0.8, 1};
  OperationalModel m = random_model(dice, 2, square[seed % 3]);
  if (seed % 2 == 1) {
    m.coordinates.assign(all_coordinates, all_coordinates + 6);
    if (seed % 4 == 1) std::reverse(m.coordinates.begin(), m.coordinates.end());
    m.lengths = {Coordinate::rxyz, Coordinate::xyz};
    if (seed % 8 == 5) m.sources.push_back(displaced_origin(dice, m.chain));
  }
  if (seed % 5 == 2) {
    const auto n = static_cast<Eigen::Index>(m.chain.independent.size());
    const auto coordinates = static_cast<Eigen::Index>(m.coordinates.size());
    m.along_motion = ErrorAlongMotion{moments_of_motion(dice, n, 1e-4), {}, {}};
    m.along_motion->tip = moments_of_motion(dice, coordinates, 2e-4);
    for (const double size : {0.1, 2e-4})
      m.along_motion->filtered.push_back(moments_of_motion(dice, coordinates, size));
  }
  return m;
}

}  // namespace qerr::testing
