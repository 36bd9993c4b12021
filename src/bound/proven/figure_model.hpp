#pragma once

#include <vector>

#include "bound/batched_error.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/proven_maximum.hpp"

namespace qerr {

/// A model whose worst case or sigma of the unfiltered position is the figure: behind a filter the half
/// widths of all errors are multiplied by ||H||_1 and their means by |H(1)|, or the sigma of the encoders by
/// ||H||_2 (in motion: that of each encoder is replaced) and that of each source by its own ratio.
///
/// The rigorous worst case has the model of the linear one.
/// @throws Error (input; key `requirements`) if sigma behind the filter is not known
OperationalModel figure_model(const OperationalModel&, const std::vector<Norms>& filters,
                              const std::vector<Eigen::VectorXd>& noise_in_motion, const Figure&);

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
  /// Value of a figure at a configuration of the last batch.
  double value(const Figure&, std::size_t configuration) const;

  std::vector<Norms> filters_;
  BatchedError errors_;
  std::size_t joints_;
  AlignedNumbers q_, figures_;
};

}  // namespace qerr
