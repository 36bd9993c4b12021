#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace qerr {

/// An error beside the quantization of the encoders, estimate - true, and where it enters.
struct ErrorSource {
  enum class Where {
    joint,    ///< a joint's coordinate: a column of J
    encoder,  ///< an encoder's coordinate: a column of J C
    origin    ///< the origin of a joint of the chain, along a direction fixed in the frame before it
  };
  Where where = Where::joint;
  std::size_t owner = 0;  ///< index of the independent joint, or of the encoder, which it is counted with
  std::size_t link = 0;   ///< of `origin`: index of the joint of the chain
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< of `origin`: unit, in the frame before
  double mean = 0, half_width = 0, sigma = 0;  ///< of the coordinate, of `origin` along the direction
  std::vector<double> gains = {};  ///< sigma behind each filter over sigma, in the order of the filters
};

/// What the sources' sigmas are multiplied with behind a filter.
/// @param h2  its norm ||H||_2, which holds for sources that do not state their gains: they are white
Eigen::VectorXd gains_behind(const std::vector<ErrorSource>&, std::size_t filter, double h2);

}  // namespace qerr
