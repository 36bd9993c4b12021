#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "qerr/encoder/encoder.hpp"

namespace qerr {

/// An error other than the quantization of the encoders, estimate - true, and where it enters.
struct ErrorSource {
  enum class Where {
    joint,    ///< a joint's coordinate: a column of J
    encoder,  ///< an encoder's coordinate: a column of J C
    origin    ///< the origin of a joint of the chain, along a direction fixed in the frame before it
  };
  Where where = Where::joint;
  std::size_t owner = 0;  ///< index of the independent joint, or of the encoder, that it is attributed to
  std::size_t link = 0;   ///< of `origin`: index of the joint of the chain
  Eigen::Vector3d direction =
      Eigen::Vector3d::Zero();  ///< of `origin`: unit vector, in the frame before the joint
  double mean = 0, half_width = 0,
         sigma = 0;  ///< of the coordinate [rad or m]; of `origin` along `direction` [m]
  /// [filter]: sigma of the filtered error over sigma, NaN if it is not known; empty: white.
  std::vector<double> sigma_ratios = {};
  /// Its error depends on the counts of its encoder: along a motion it is part of noise_in_motion.
  bool in_counts = false;
};

/// [encoder][filter]: sigma behind the filter over sigma before it; NaN: not known.
using SigmaRatios = std::vector<std::vector<double>>;

/// Slow errors of the encoders within their `accuracy` A, a bound of unknown shape: half width A, and sigma
/// A/sqrt(2), that of a sine of amplitude A and unknown phase (a uniform error would have A/sqrt(3)); and
/// those of their gears within `gear_accuracy`, likewise.
std::vector<ErrorSource> accuracy_sources(const std::vector<Encoder>&, const SigmaRatios& of_encoders,
                                          const SigmaRatios& of_gears);

/// Whether the spectra of all sources are known, and with them sigma behind the filter.
bool sigma_is_known(const std::vector<ErrorSource>&, std::size_t filter);

/// Ratios sigma behind a filter over sigma before it, one per source; 0 where it is not known.
/// @param filter  index into ErrorSource::sigma_ratios
/// @param h2      ||H||_2 of the filter, the ratio of a white source
/// @param beside_noise_in_motion  0 also for sources that are part of noise_in_motion
Eigen::VectorXd sigma_ratios(const std::vector<ErrorSource>&, std::size_t filter, double h2,
                             bool beside_noise_in_motion = false);

}  // namespace qerr
