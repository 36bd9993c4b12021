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

/// How one joint moves at an instant.
struct JointState {
  double position = 0;      ///< [rad or m]
  double velocity = 0;      ///< [rad/s or m/s]
  double acceleration = 0;  ///< [rad/s^2 or m/s^2]
};

/// A motion made ready to be evaluated at any time.
///
/// A table is interpolated by cubic Hermite polynomials with central slopes: exact in its rows, continuous in
/// velocity. Before time 0 moves and tables rest, and so do tables after their end; sines and constant
/// velocities have no end.
class MotionPath {
 public:
  explicit MotionPath(const Motion&);
  MotionPath(MotionPath&&) noexcept;
  ~MotionPath();

  JointState at(std::size_t joint, double time) const;

  /// Positions of the independent joints [rad or m].
  Eigen::VectorXd position(double time) const;

  /// Their derivative [rad/s or m/s].
  Eigen::VectorXd velocity(double time) const;

  /// The derivative of that; where it jumps, the value after it [rad/s^2 or m/s^2].
  Eigen::VectorXd acceleration(double time) const;

  /// One joint alone.
  double position(std::size_t joint, double time) const { return at(joint, time).position; }

  /// One joint at `batch_size` instants, many of them at once; in the last bits `position` may differ.
  /// @param time  increasing, as is best for speed, and as `to` aligned to 64 bytes [s]
  void positions(std::size_t joint, const double* time, double* to, InstructionSet = instruction_set()) const;

  std::size_t joints() const { return count_; }

 private:
  /// position + velocity s + acceleration s^2/2 + jerk s^3/6, s = time - start.
  struct Phase {
    double start = 0, position = 0, velocity = 0, acceleration = 0, jerk = 0;
  };
  /// Moves as polynomials: once from the center, then a cycle from where the last move ends.
  struct Moves {
    std::vector<Phase> first, cycle;
    double first_end = 0, cycle_length = 0;
  };

  JointState of_table(std::size_t joint, double time) const;
  static JointState of_moves(const Moves&, double time);
  static JointState of_phases(const std::vector<Phase>&, double time);
  static double append(const Move&, double from, double start, std::vector<Phase>&);

  bool within_lanes(const std::vector<Oscillation>&, const double* time) const;

  Motion motion_;
  std::vector<std::vector<Oscillation>> oscillations_;  // of each joint, as the lanes take them
  std::vector<Moves> moves_;
  std::size_t count_ = 0;
};

/// Lowest and highest position of every independent joint at the samples 0, 1/sample_rate, ... of the motion.
/// @returns joints x 2 [rad or m]
Eigen::MatrixX2d extent(const Motion&);

}  // namespace qerr
