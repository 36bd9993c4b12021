#pragma once

#include <vector>

#include "bound/batched_error.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/proven_maximum.hpp"

namespace qerr {

/// The figures of `workspace` at given configurations.
class FigureValues {
 public:
  FigureValues(const OperationalModel&, const std::vector<Norms>& filters,
               const std::vector<Eigen::VectorXd>& noise_in_motion);

  /// [figure][configuration]
  std::vector<std::vector<double>> operator()(const std::vector<Figure>&,
                                              const std::vector<Eigen::VectorXd>& configurations);

  /// [figure]: of 64 blocks of 1024 Sobol points in the ranges the configuration with the largest value each.
  std::vector<std::vector<Eigen::VectorXd>> best_samples(const std::vector<Figure>&,
                                                         const std::vector<Limits>& ranges);

 private:
  /// Of a configuration of the last batch.
  double value(const Figure&, std::size_t configuration) const;

  std::vector<Norms> filters_;
  BatchedError errors_;
  std::size_t joints_;
  AlignedNumbers q_, figures_;
};

}  // namespace qerr
