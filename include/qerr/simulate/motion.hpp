#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "qerr/core/instruction_set.hpp"

namespace qerr {

/// amplitude * sin(2 pi frequency t + phase).
struct Sine {
  double amplitude = 0;  ///< [rad or m]
  double frequency = 0;  ///< [Hz]
  double phase = 0;      ///< [rad]
};

struct Oscillation;

/// One move of a point-to-point motion: from standstill to standstill, then a dwell.
struct Move {
  double to = 0;            ///< final position [rad or m]
  double velocity = 0;      ///< limit [rad/s or m/s]
  double acceleration = 0;  ///< limit [rad/s^2 or m/s^2]
  double jerk = 0;          ///< limit [rad/s^3 or m/s^3]; 0: trapezoidal velocity
  double dwell = 0;         ///< pause after the move [s]
};

/// Motion of one joint: center + velocity t + sum of sines, or a sequence of moves that starts at the center
/// and is repeated.
struct JointMotion {
  double center = 0;    ///< [rad or m]
  double velocity = 0;  ///< [rad/s or m/s]
  std::vector<Sine> sines;
  std::vector<Move> moves;
};

/// A recorded or planned motion.
struct MotionTable {
  std::vector<double> time;   ///< strictly increasing [s]
  Eigen::MatrixXd positions;  ///< independent joints x times [rad or m]
};

/// `motion:` of the spec: the motion of every independent joint from time 0 to `duration`.
struct Motion {
  double sample_rate = 0;           ///< of the controller that reads the encoders [Hz]
  double duration = 0;              ///< [s]
  std::optional<double> settling;   ///< initial part that statistics exclude [s]
  std::vector<JointMotion> joints;  ///< one per independent joint; empty if a table gives the motion
  MotionTable table;                ///< time 0 of the motion is its first row
  std::string file = {};            ///< of the table; "" without a table
};

/// Lowest and highest position of every independent joint at the samples 0, 1/sample_rate, ... of the motion.
/// @returns joints x 2 [rad or m]
Eigen::MatrixX2d extent(const Motion&);

}  // namespace qerr
