#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "bound/error_plan.hpp"
#include "kinematics/batched_jacobian.hpp"
#include "lanes/batch.hpp"

namespace qerr {

/// The largest length of a vector m + sum s_i g_i over all signs s_i = +-1: the farthest corner of a box that
/// is mapped linearly to space.
///
/// The farthest point of a zonotope is a vertex. Up to 12 generators all signs are tried. Beyond, the
/// vertices are enumerated: each lies at an edge along some g_i of a face with the normal d = g_i x g_j,
/// where the sign of g_k is that of its component along d; in the face, along d x g_i; along the edge, along
/// g_i. That is O(n^3) for n generators.
/// @param generators  3 x n
double largest_corner(const Eigen::Vector3d& mean, const Eigen::Matrix3Xd& generators);

/// Figures of the lengths `OperationalModel::lengths` of batches of configurations, from those of their
/// components.
///
/// sigma is the root of the components' summed variances. The worst case is the largest length over the
/// corners of the box of all errors at joints and encoders (largest_corner.hpp), linear kinematics; errors
/// of origins and along a motion add their largest lengths to it.
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
  void set_worst(const Length&, std::size_t index, std::size_t configuration, double* figures) const;
  void set_sigmas(const Length&, std::size_t index, std::size_t configuration, double* figures) const;
  double root_of_sum(const Length&, std::size_t block, const double* figures) const;

  FigureLayout layout_;
  std::vector<Norms> filters_;
  std::vector<Generator> generators_;
  std::vector<Length> lengths_;
  bool biased_ = false, rigorous_, own_worst_, own_sigma_;
  std::vector<bool> in_motion_;  // [filter]
  double rotation_remainder_, rotation_angle_;
  BatchedJacobian jacobian_;
  AlignedNumbers columns_;
  std::size_t joints_, components_;
};

}  // namespace qerr
