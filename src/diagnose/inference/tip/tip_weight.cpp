#include "diagnose/inference/tip/tip_weight.hpp"

#include <algorithm>
#include <cmath>

#include "core/solve.hpp"
#include "core/statistics.hpp"

namespace qerr {

double gain_of(const TipSolution& s, const Eigen::MatrixXd& beyond) {
  for (Eigen::Index i = 0; i < beyond.cols(); ++i)
    if (beyond.col(i).isZero(0)) return 0;
  const Eigen::MatrixXd weighted = s.weight.asDiagonal() * beyond;
  const Eigen::VectorXd score = weighted.transpose() * s.residual;
  Eigen::MatrixXd information = beyond.transpose() * weighted;
  information.diagonal().array() *= 1 + 1e-10;
  return 0.5 * score.dot(solve_symmetric(information, score));
}

double variance_inflation(const TipModel& model, const TipSolution& with, const Eigen::MatrixXd& columns) {
  const auto coordinates = static_cast<Eigen::Index>(model.evidence().axes.size());
  return std::max(TipModel::variance_inflation(with, columns, coordinates),
                  model.quantization_inflation(model.beyond(columns)));
}

double variance_inflation(const TipModel& model, std::size_t term) {
  const auto coordinates = static_cast<Eigen::Index>(model.evidence().axes.size());
  return std::max(TipModel::variance_inflation(model.solution(), model.columns(term), coordinates),
                  model.quantization_inflation(model.beyond_others(term)));
}

double p_value(double gain, Eigen::Index coefficients) {
  return gain > 0 ? chi_squared_tail(2 * gain, static_cast<double>(coefficients)) : 1;
}

double signal_to_noise(const TipSolution& s, const Eigen::MatrixXd& columns,
                       const Eigen::VectorXd& coefficients) {
  const Eigen::VectorXd added = columns * coefficients;
  return std::sqrt(s.weight.dot(added.cwiseAbs2()) / static_cast<double>(added.size()));
}

double penalty(const TipModel& model, const TipTerm& t) {
  // Schwarz's price twice: what neighbouring rows leave is not independent.
  if (t.of_record()) return unnamed_penalty + price(model, t.size());
  if (!t.term.named()) return unnamed_penalty;
  return t.kinematic() || model.evidence().ordered ? 0 : unnamed_penalty;
}

double required_signal_to_noise(const TipTerm& t) {
  if (t.kinematic()) return 1;
  return t.term.named() ? 1.7 : 2;
}

double price(const TipModel& model, Eigen::Index coefficients) {
  return 0.5 * static_cast<double>(coefficients) * std::log(static_cast<double>(model.entries().size()));
}

}  // namespace qerr
