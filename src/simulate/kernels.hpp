#pragma once

#include <cstddef>

#include "kinematics/kernels.hpp"
#include "lanes/select_kernels.hpp"

// Interface of the simulation kernels, included by files that are compiled per instruction set (see
// kinematics/kernels.hpp for the headers that these must not include).
//
// Lanes are instants where no state is carried from sample to sample (motion, quantizers, kinematics), and
// channels where it is (filters). Runs are not used as lanes, since most simulations are a single run.

namespace qerr {

/// amplitude sin(rate t + phase).
struct Oscillation {
  double amplitude, rate, phase;
};

/// center + velocity t + oscillations.
struct SinusoidPath {
  double center, velocity;
  const Oscillation* oscillations;
  std::size_t count;
};

/// Counts of an encoder: floor(position/resolution + 1/2), or floor(position/resolution) if `down`.
struct Quantizer {
  double resolution;
  bool down;
};

/// Contribution of one joint to a column: a factor of the column of the joint, scaled by
/// `PathErrorPlan::scale`.
struct ColumnPart {
  std::size_t joint;
  double factor;
};

/// Derivative of the tip with respect to an error: columns of the encoders, then of the error sources.
struct ErrorColumn {
  std::size_t first, parts;  ///< its ColumnParts
  bool direct;               ///< a single part of factor 1: the column is that of the joint
  bool origin;               ///< displacement of a joint origin along `direction`, in the axes after joint
  std::size_t link;          ///< `link - 1`, for link 0 in those of the base
  double direction[3];
  double mean, half_width;  ///< of an encoder in units of its resolution
};

/// Constants of the errors along a path. Borrows the memory of `PathErrors`.
struct PathErrorPlan {
  FoldedPath chain, built;  ///< as modelled and as built
  bool as_modelled;         ///< both are the same
  const double* scale;      ///< of the column of each joint, with the sign of its axis
  std::size_t encoders, sources;
  const ErrorColumn* columns;
  const ColumnPart* parts;
  const double* per_resolution;  ///< 1/Delta of each encoder
  std::size_t coordinates;
  const int* rows;  ///< 0..2 position, 3..5 rotation vector, 6..8 roll pitch yaw
  bool rotations, angles, biased;
  bool tip_frame;            ///< rows 0..5 are in the axes of the tip
  bool mixed;                ///< a column is a sum of several joints
  double remainder;          ///< linearization remainder of the position (bound/operational_error.hpp)
  double largest_remainder;  ///< its upper bound in any configuration, or infinity
  const double* per_column;  ///< factor of |scaled column|
  double rotation, rotation_angle;
  const double* center_mean;  ///< of each coordinate
  std::size_t width;          ///< of a row: the number of channels, padded to whole lanes
};

/// Sums of channels about their first values, which avoids cancellation: one number for each channel.
struct ChannelTally {
  double *shift, *sum, *squares, *peak;
};

/// Sine and cosine - 1 of a small angle, of numbers or lanes; the next terms of the series are below 5e-18.
template <class Number>
struct SmallAngle {
  static constexpr double largest = 0x1p-8;  ///< [rad]
  Number sine, less;

  [[gnu::always_inline]] explicit SmallAngle(const Number& angle) {
    const Number square = angle * angle;
    sine = angle + angle * square * (square * (1.0 / 120) - 1.0 / 6);
    less = square * (square * (1.0 / 24) - 0.5);
  }
};

/// Displacement of a run along a joint: a rotation, or a translation stored in place of the sine.
using Displacement = SmallAngle<double>;

/// Inputs and outputs of a batch of instants, channel-major; only `rows` are instant by instant.
struct PathErrorBatch {
  const double *joint, *built_joint, *estimate;  ///< independent joints
  const double *encoder, *measured;              ///< true and measured
  const double* path_sines;                      ///< of the path shared by all runs, from `sines`; or null
  const Displacement* turns;                     ///< [moving joint]: of this run from that path
  double* rows;       ///< [instant][width]: error, linear part, contributions of the encoders, mean
  double* variance;   ///< [coordinate][instant]: sum of (J C Delta)^2 over the encoders
  double* rigorous;   ///< [coordinate]: largest bound so far
  double* deviation;  ///< [coordinate]: the same of the difference from the mean at the centre
  double* scratch;
};

struct SimulationKernels {
  std::size_t lanes;
  std::size_t (*errors_scratch_size)(const PathErrorPlan&);  ///< numbers in PathErrorBatch::scratch
  /// (first + i)/rate at 64 instants i; from `count` on, the time of instant count - 1.
  void (*times)(double first, std::size_t count, double rate, double* out);
  void (*positions)(const SinusoidPath&, const double* time, double* out);
  /// A row of 64 instants plus a shift.
  void (*displace)(const double* row, double shift, double* out);
  /// out = matrix in: rows of 64 instants, row-major matrix.
  void (*mix)(std::size_t n, const double* matrix, const double* in, double* out);
  /// Counts and counts * resolution of one encoder. @returns whether all of them are integers within 2^53
  bool (*quantize)(const Quantizer&, const double* position, double* counts, double* measured);
  /// Whether |factor x| <= limit for all numbers of a row of 64.
  bool (*within)(const double* row, double factor, double limit);
  /// Sines and cosines of the revolute and positions of the prismatic joints along a path, 2 numbers for each
  /// joint and instant: [vector of instants][joint].
  void (*sines)(const FoldedPath&, const double* joint, double* out);
  void (*errors)(const PathErrorPlan&, const PathErrorBatch&);
  /// @param peaks  number of channels whose peak is computed
  /// @param fresh  the tally is empty
  void (*tally)(const double* in, std::size_t stride, std::size_t rows, std::size_t width, std::size_t peaks,
                bool fresh, const ChannelTally&);
};

}  // namespace qerr
