#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "bound/batched_error.hpp"
#include "bound/kernels.hpp"
#include "control/loop_response.hpp"
#include "kinematics/sampler.hpp"
#include "lanes/batch.hpp"

namespace qerr {

/// Rows c(q) of the model's signals beside the tip's coordinates and lengths, signals x independent joints.
Eigen::MatrixXd signal_rows(const OperationalModel&, const Eigen::VectorXd& q);

/// Figures of these signals of batches of configurations: with c the derivative by each independent error,
/// sum |c| half width + |sum c mean| and sigma^2 = sum c^2 sigma^2, and the error along the motion. Behind a
/// filter half widths are multiplied by ||H||_1, means by |H(1)| and each sigma by its own ratio.
class SignalErrors {
 public:
  SignalErrors(const OperationalModel&, const ErrorFigures&, const FigureLayout&);

  /// @param q  as in BatchedError
  void operator()(const double* q, double* figures);

 private:
  /// Factors of the errors behind a filter, the first entry of `behind_` being the position.
  struct Behind {
    double l1 = 1, dc_gain = 1;
    Eigen::VectorXd variance, in_motion;  ///< [error]; empty: not known
    Eigen::VectorXd peak, along_motion;   ///< [signal]: added to the bound, and to the variance
  };
  double remainder(std::size_t signal, const Eigen::VectorXd& q) const;
  void set(std::size_t signal, const Eigen::VectorXd& q, const Eigen::VectorXd& column,
           double* figures) const;
  /// Stores the figures of a signal with norms of its own.
  void set_closed(std::size_t signal, const Eigen::VectorXd& q, const LoopsAt&, double* figures) const;

  OperationalModel model_;
  FigureLayout layout_;
  Eigen::MatrixXd moved_;  // independent joints x errors
  Eigen::VectorXd half_width_, mean_;
  Eigen::VectorXd white_, slow_;                     // [error]: sigma of errors of white and of other spectra
  std::vector<std::vector<LoopRatio>> slow_ratios_;  // [error][joint]: as in LoopsAt; empty: white
  Eigen::VectorXd joints_;                           // worst case of the independent joints
  std::vector<Behind> behind_;
  LoopsOfBatch loops_;
  bool rigorous_, own_worst_, own_sigma_;
};

/// The largest length of a vector m + sum s_i g_i over all signs s_i = +-1, as of
/// BoundKernels::largest_corners.
/// @param generators  3 x n
double largest_corner(const Eigen::Vector3d& mean, const Eigen::Matrix3Xd& generators);

/// Figures of the lengths `OperationalModel::lengths` of batches of configurations, from those of their
/// components.
///
/// sigma is the root of the components' summed variances. The worst case is the largest length over the
/// corners of the box of all errors at joints and encoders (BoundKernels::largest_corners), linear
/// kinematics; errors of origins and along a motion add their largest lengths to it.
class LengthErrors {
 public:
  LengthErrors(const OperationalModel&, const ErrorFigures&, const FigureLayout&, InstructionSet);

  /// @param q        as in BatchedError
  /// @param figures  those of the components are known
  void operator()(const double* q, double* figures);

 private:
  struct Generator {
    Eigen::VectorXd of_joints;  ///< derivative of the chain's joints
    double half_width, mean;
  };
  /// Components of a length, the first of which is at `first` among the rows of the Jacobian.
  struct Length {
    std::size_t first;
    std::array<std::size_t, 3> components;  ///< indices of the model's coordinates
    double added = 0;                       ///< largest length of errors of origins and along a motion
    std::vector<double> added_behind = {};  ///< [filter]
  };

  void add_generator(const OperationalModel&, const IndependentError&);
  /// The generators' mean and corners at each configuration of the batch.
  void set_vectors(const Length&);
  /// [configuration]: the largest length of `of_mean` times the mean and a corner.
  const double* largest_corners(double of_mean);
  void set_worst(const Length&, std::size_t index, double* figures);
  void set_sigmas(const Length&, std::size_t index, std::size_t configuration, double* figures) const;
  double root_of_sum(const Length&, std::size_t block, const double* figures) const;

  FigureLayout layout_;
  std::vector<Norms> filters_;
  std::vector<Generator> generators_;
  std::vector<Length> lengths_;
  bool biased_ = false, rigorous_, own_worst_, own_sigma_;
  std::vector<bool> in_motion_;  // [filter]
  double rotation_remainder_, rotation_angle_;
  const BoundKernels& kernels_;
  BatchedJacobian jacobian_;
  AlignedNumbers columns_;
  AlignedNumbers mean_, scaled_mean_;  // [axis][batch_size]
  AlignedNumbers corners_;             // [generator][axis][batch_size]
  AlignedNumbers largest_, scratch_;
  std::size_t joints_, components_;
};

}  // namespace qerr
