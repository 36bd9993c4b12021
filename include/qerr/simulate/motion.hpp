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

/// One leg of a point-to-point motion: from rest to rest, then a dwell.
struct Move {
  double to = 0;            ///< [rad or m]
  double velocity = 0;      ///< at most [rad/s or m/s]
  double acceleration = 0;  ///< at most [rad/s^2 or m/s^2]
  double jerk = 0;          ///< at most [rad/s^3 or m/s^3]; 0: a trapezoid of velocity
  double dwell = 0;         ///< rest after it [s]
};

/// Motion of one joint: center + velocity t + sum of sines, or moves that start at the center and are gone
/// through again and again.
struct JointMotion {
  double center = 0;    ///< [rad or m]
  double velocity = 0;  ///< [rad/s or m/s]
  std::vector<Sine> sines;
  std::vector<Move> moves;
};

/// A motion that was recorded or planned elsewhere.
struct MotionTable {
  std::vector<double> time;   ///< strictly increasing [s]
  Eigen::MatrixXd positions;  ///< independent joints x times [rad or m]
};

/// `motion:` of the spec: what every independent joint does from time 0 to `duration`.
struct Motion {
  double sample_rate = 0;           ///< of the controller that reads the encoders [Hz]
  double duration = 0;              ///< [s]
  std::optional<double> settling;   ///< start of the motion that is left out of statistics [s]
  std::vector<JointMotion> joints;  ///< one per independent joint; empty when a table gives the motion
  MotionTable table;                ///< its time 0 is its first row
  std::string file = {};            ///< the table's, "" without
};

/// Lowest and highest position of every independent joint at the samples 0, 1/sample_rate, ... of the motion.
/// @returns joints x 2 [rad or m]
Eigen::MatrixX2d extent(const Motion&);

}  // namespace qerr
