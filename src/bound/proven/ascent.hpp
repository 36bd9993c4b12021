#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "bound/batched_error.hpp"
#include "bound/proven/box_bound.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/proven_maximum.hpp"
#include "qerr/kinematics/robot_model.hpp"

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

/// Maxima along one joint.

/// a_g + b_g cos(t) + c_g sin(t), one row a term: columns a, b, c.
using Harmonics = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// The harmonics from the values at t = 0, 2 pi/3 and -2 pi/3.
Harmonics harmonics(const Eigen::VectorXd& at_0, const Eigen::VectorXd& at_plus,
                    const Eigen::VectorXd& at_minus);

/// t in the range that maximizes sum_g |a_g + b_g cos t + c_g sin t|.
///
/// Between two zeros of its terms the sum is a harmonic itself, whose maximum is known; a zero of a term is
/// no maximum, as the magnitude is convex there.
double argmax_of_magnitudes(const Harmonics&, const Limits& range);

/// t in the range that maximizes sum_g (a_g + b_g cos t + c_g sin t)^2, a trigonometric polynomial of degree
/// 2: the best of its stationary points, between 64 samples, and of the ends.
double argmax_of_squares(const Harmonics&, const Limits& range);

/// t in the range near which f is largest: of `samples` equally spaced values the three highest peaks
/// are refined by golden sections.
double argmax_by_search(const std::function<double(double)>& f, const Limits& range, int samples);

/// A local maximum of the figure over the box that is not below that at `start`: each joint in turn is moved
/// to the best place along its range, until the figure no longer grows by 1e-12 of itself.
///
/// Along one axis that turns the figure's terms are harmonics (Harmonics); a longest corner is that of
/// the corner which is longest at present, whose square is one of a variance. Along a prismatic axis a figure
/// is convex: its maximum is at an end. Joints that move several axes are searched.
Eigen::VectorXd ascend(const ErrorTerms&, const std::vector<Limits>& ranges, Eigen::VectorXd start);

}  // namespace qerr
