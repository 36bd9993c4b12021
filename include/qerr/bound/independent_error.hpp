#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "qerr/encoder/transmission.hpp"

namespace qerr {

/// Mean, largest magnitude and covariance of signals over a record.
struct SignalMoments {
  Eigen::VectorXd mean, peak;
  Eigen::MatrixXd covariance;  ///< about the mean
};

/// Sigma of the true motion and of the torque in a joint's closed loop over that of the error of its reading;
/// NaN: not known.
struct LoopRatio {
  double motion = 0, torque = 0;
};

/// Error, estimate - true, that effects add along one motion, without quantization: a known signal, the same
/// in every run, and independent of the sampled configurations.
///
/// An effect behind the quantizer that multiplies counts also multiplies the quantization error, which is not
/// part of this signal.
struct ErrorAlongMotion {
  SignalMoments joints;  ///< of the independent joints [rad or m]
  SignalMoments tip;     ///< of the model's coordinates, then its signals of other kinds [m or rad]
  std::vector<SignalMoments> filtered;   ///< [filter]: the same signals behind it [m/s, rad/s, ...]
  std::vector<LoopRatio> in_loops = {};  ///< [joint]; empty: no closed loop is asked for
};

/// An error that is independent of all others, estimate - true, and where it enters: quantization of an
/// encoder, an encoder's accuracy, the share of an effect, the displacement of a joint's origin.
struct IndependentError {
  enum class Where {
    joint,    ///< a joint's coordinate: a column of J
    encoder,  ///< an encoder's coordinate: a column of J C
    origin    ///< the origin of a joint of the chain, along a direction fixed in a frame of the chain
  };
  Where where = Where::joint;
  std::size_t owner = 0;  ///< index of the independent joint, or of the encoder, that it is attributed to
  std::size_t link = 0;   ///< of `origin`: the joint of the chain before which it enters (OriginPlace)
  Eigen::Vector3d direction =
      Eigen::Vector3d::Zero();  ///< of `origin`: unit vector, in the frame before `link`
  double mean = 0, half_width = 0,
         sigma = 0;  ///< of the coordinate [rad or m]; of `origin` along `direction` [m]
  /// [filter]: sigma of the filtered error over sigma, NaN if it is not known; empty: white.
  std::vector<double> sigma_ratios = {};
  std::vector<LoopRatio> loop_ratios = {};  ///< [joint]; empty: white, or a model without `control`
  /// Its error depends on the counts of its encoder: along a motion it is part of noise_in_motion.
  bool in_counts = false;
};

/// Quantization of the encoders, in their order: uniform over an interval Delta about its mean, half width
/// Delta/2 (paper, Eq. 3), sigma Delta/sqrt(12) (Eq. 9), white; behind it `others`.
std::vector<IndependentError> independent_errors(const Transmission&,
                                                 const std::vector<IndependentError>& others);

/// Derivative of the independent joints with respect to an error at a joint, e_i, or at an encoder, column i
/// of C.
/// @pre not at an origin
Eigen::VectorXd moved_joints(const Transmission&, const IndependentError&);

/// What an error that is not white passes: of each filter and of each joint's loop, as in IndependentError.
struct SigmaRatios {
  std::vector<double> filters;
  std::vector<LoopRatio> loops;
};

/// Slow errors of the encoders within their `accuracy` A, a bound of unknown shape: half width A, and sigma
/// A/sqrt(2), that of a sine of amplitude A and unknown phase (a uniform error would have A/sqrt(3)); and
/// those of their gears within `gear_accuracy`, likewise.
/// @param of_encoders, of_gears  one for each encoder
std::vector<IndependentError> accuracy_sources(const std::vector<Encoder>&,
                                               const std::vector<SigmaRatios>& of_encoders,
                                               const std::vector<SigmaRatios>& of_gears);

/// Whether the spectra of all sources are known, and with them sigma behind the filter.
bool sigma_is_known(const std::vector<IndependentError>&, std::size_t filter);

/// Ratios sigma behind a filter over sigma before it, one per source; 0 where it is not known.
/// @param filter  index into IndependentError::sigma_ratios
/// @param h2      ||H||_2 of the filter, the ratio of a white source
/// @param beside_noise_in_motion  0 also for sources that are part of noise_in_motion
Eigen::VectorXd sigma_ratios(const std::vector<IndependentError>&, std::size_t filter, double h2,
                             bool beside_noise_in_motion = false);

/// Error of every independent joint, estimate - true, in chain order [rad or m].
struct JointError {
  Eigen::VectorXd mean;        ///< C m with the encoders' mean errors m; 0 when all round to nearest
  Eigen::VectorXd half_width;  ///< 0.5 |C| Delta (paper, Eq. 3, carried through the coupling)
  Eigen::VectorXd worst_case;  ///< half_width + |mean|
  /// sqrt(diag(C diag(Delta^2/12) C^T)) (paper, Eq. 9, whose covariance is diagonal only for C = I).
  Eigen::VectorXd sigma;
};

/// Joint error of a transmission, from the quantization intervals of its encoders and the sources at joints
/// and encoders: means, half widths and variances add (displaced origins do not move a joint).
/// @param along_motion  of the joints, or null: its peak adds to half_width and its variance to that of sigma
JointError joint_error(const Transmission&, const std::vector<IndependentError>& = {},
                       const SignalMoments* along_motion = nullptr);

}  // namespace qerr
