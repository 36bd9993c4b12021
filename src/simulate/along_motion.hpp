#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "qerr/bound/effect_shares.hpp"
#include "qerr/bound/independent_error.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/filter/filter.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/kinematics/chain.hpp"
#include "qerr/simulate/simulate.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr {

/// What effects that are not random add along a motion: their signal path without the rounding to counts,
/// then exact kinematics, then the filters, sample by sample at the rate of each filter. As in a simulation,
/// a filter starts in the steady state of the first error, and samples before `settling` do not count.
///
/// Instead of being rounded, a position is shifted by what the effects change in the mean rounding error over
/// the position of the encoder's zero. Peaks are those of this signal: at single positions of the zero an
/// effect that depends on the position differs from them (`change_with_zero`), and one that depends
/// on the place within a line or on the count itself is none of this signal's.
/// @param settling  initial part that is excluded [s]
ErrorAlongMotion effects_along_motion(const OperationalModel&, const std::vector<Effect>&, const Motion&,
                                      const std::vector<Filter>&, double settling);

/// Error that one effect adds alone, at its encoder's coordinate [rad or m]: a signal of one row.
SignalMoments effect_along_motion(const OperationalModel&, const Effect&, const Motion&, double settling);

/// Largest change of the error that effects add at an encoder's coordinate where the zeros of the encoders
/// move by half a count, the range of all zeros: at its ends, since it changes steadily over so short a
/// distance [rad or m].
double change_with_zero(const OperationalModel&, const std::vector<Effect>&, std::size_t encoder,
                        const Motion&, double settling);

/// Usage of joints and encoders by a motion: positions and velocities at its samples, and efforts by inverse
/// dynamics if the robot has masses. Means are over the samples after `motion.settling`, ranges over all. At
/// most 1e5 samples (1e4 for efforts), evenly spaced over the motion, are evaluated. Ranges of positions and
/// velocities include a bound on their peaks between the samples, and positions half a count for the unknown
/// zero of the encoder; those of efforts do not.
/// @param margin  time before and after the motion that the ranges include, for delayed samples [s]
RobotUsage usage_in_motion(const OperationalModel&, const Motion&, double margin = 0);

/// Tracking error of a filter along a motion: its output for the tip's true position, minus the true
/// derivative of that at the same instant. It is what lag and ripple of the filter do to an encoder without
/// errors.
struct TrackingMoments {
  double mean = 0, variance = 0, peak = 0;  ///< over the samples that the filter uses after the settling
  /// Covariance with the filtered errors of the effects. Quantization adds nothing: its mean over the
  /// position of the encoder's zero is the same at every sample.
  double with_effects = 0;
};

/// The filter has settled to the motion: it starts at a time before 0 by the settling, through which sines
/// and velocities are continued, and moves and tables stand still.
/// @param settling  initial part that does not count [s]
/// @pre the rates of the filters divide that of the motion
/// @returns [coordinate]: of x y z, in the axes of the model; NaN for rotations, whose vector is no
/// derivative, and for third and higher derivatives
std::vector<TrackingMoments> tracking_along_motion(const OperationalModel&, const std::vector<Effect>&,
                                                   const Motion&, const Filter&, double settling);

/// Motion of the tip in the base frame at one instant.
struct TipMotion {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< of the tip's origin: J q' [m/s]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< J q'' + J' q' [m/s^2]
};

/// Forward recursion along the chain (Siciliano et al., Robotics, 2009, Sec. 7.5.1).
/// @param q, velocity, acceleration  of the independent joints [rad or m, per s, per s^2]
TipMotion tip_motion(const Chain&, const Eigen::VectorXd& q, const Eigen::VectorXd& velocity,
                     const Eigen::VectorXd& acceleration);

/// Position of an encoder along a record [counts]: range, first value, length of the path, and the number of
/// different positions within a count, of at most 65536.
struct Travel {
  double lower = 0, upper = 0, start = 0, length = 0, distinct = 65536;
  double range() const { return upper - lower; }
};

/// One for each encoder.
/// @param effects  that displace what is rounded
std::vector<Travel> travels(const OperationalModel&, const std::vector<Effect>& effects,
                            const UnroundedRecord&);

/// Runs over which the sigma_exact of a simulation is the mean, with the encoders' zeros equally spaced over
/// a count: 16 to 256, more for motions that pass few counts, fewer for long ones.
/// @param samples  of the motion
/// @returns 0 if an encoder that moves crosses an edge in less than 64 runs: too few for a mean
std::uint64_t zeros_of_simulation(const std::vector<Travel>&, std::uint64_t samples);

/// sigma of the filtered error of each encoder along a motion, in quantization intervals:
///
///     sigma^2 = mean over the encoder's zero u in a count, and over the samples n of the record, of y_n^2,
///     y = filter of e_n = [x_n + u] - x_n - u, x_n the encoder's position in counts,
///
/// without the assumption IPQN. As in a simulation, the filter starts in the steady state of e_0, and samples
/// before `settling` do not count. The mean over u is that of 64 to 4096 zeros, one at a random place in each
/// of equal parts of a count (of the part in which the record crosses an edge, if that is not all: for the
/// others it is known).
///
/// Effects within a line make e_n = [g(x_n + u)] - x_n - u, u uniform over the whole line. With noise, y is
/// the filtered mean of the error over the noise, and the variance about it, white, is added: with s the
/// noise in counts, at V counts a sample,
///
///     sigma^2 = sum_k (w_k |H(kV)|^2 + (1 - w_k) ||H||_2^2)/(2 pi^2 k^2) + s^2 ||H||_2^2,
///     w_k = exp(-4 pi^2 k^2 s^2)
///
/// (no correlation of noise and rounding error remains in the mean over u). Jitter of the sampling instants
/// is noise of the speed's size. Behind effects on the decoder, y is the filter of the error less its mean
/// over u. The figure is within 0.5 % of that of infinitely many zeros; not so for jitter
/// where other effects change the speed at the encoder, or over a good part of a line with an error of its
/// own: it is linearized about the position, with the speed of the joint.
/// @param effects   that displace what is rounded or change its counts
/// @param settling  initial part that is excluded [s]
/// @returns one per encoder; empty if the record has more than `longest_record` samples
std::optional<Eigen::VectorXd> sigma_along_motion(const OperationalModel&, const std::vector<Effect>& effects,
                                                  const Motion&, const Filter&, double settling);

/// Part of effects within a line alone, without rounding to counts [quantization intervals].
/// @pre the record has at most `longest_record` samples
Eigen::VectorXd sigma_within_line(const OperationalModel&, const std::vector<Effect>& effects, const Motion&,
                                  const Filter&, double settling);

/// A filter with derivative 1 among the estimators.
struct VelocityFilter {
  std::string name;
  Filter filter;
  Norms norms;
  std::vector<std::size_t> joints;  ///< that it passes; empty: all
};

/// Runs every filter and estimator on the encoders' counts along a motion, and compares each estimate of a
/// joint's velocity with the true one.
///
/// The counts are those of `simulate`, with all effects; the edges are those of the disc, with the effects of
/// stages `disc` and `line` (estimators/estimator.hpp). A joint's velocity is the coupling times those of the
/// encoders. A filter of a lower rate is judged at its own samples.
///
/// The delay tau minimizes the mean square of v^(t) - v(t - tau), by Gauss and Newton from 0.
/// @param settling  initial part that does not count [s]
/// @throws Error (input; key `motion.sample_rate`) if a filter's rate does not divide that of the motion
std::vector<EstimatedVelocity> compare_velocities(const OperationalModel&, const std::vector<VelocityFilter>&,
                                                  const std::vector<EstimatorDesign>&, const Motion&,
                                                  const std::vector<Effect>&, double settling,
                                                  const SimulationOptions&);

}  // namespace qerr
