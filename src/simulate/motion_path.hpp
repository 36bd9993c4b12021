#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "qerr/core/instruction_set.hpp"
#include "qerr/simulate/simulate.hpp"

namespace qerr {

struct Oscillation;

/// Motion of one joint at an instant.
struct JointState {
  double position = 0;      ///< [rad or m]
  double velocity = 0;      ///< [rad/s or m/s]
  double acceleration = 0;  ///< [rad/s^2 or m/s^2]
};

/// A motion prepared for evaluation at any time.
///
/// A table is interpolated by the cubic spline that is exact at its rows, with continuous velocity and
/// acceleration, and with one polynomial over its first two intervals and over its last two (not-a-knot).
/// Moves stand still before time 0, tables before their first and after their last
/// row; sines and constant velocities are unlimited in time.
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

  /// Their second derivative, continuous from the right [rad/s^2 or m/s^2].
  Eigen::VectorXd acceleration(double time) const;

  /// Position of one joint [rad or m].
  double position(std::size_t joint, double time) const { return at(joint, time).position; }

  /// Positions of one joint at `batch_size` instants, vectorized; they may differ from `position` by
  /// rounding.
  /// @param time  [s]; fastest if increasing. Both arrays are aligned to 64 bytes.
  void positions(std::size_t joint, const double* time, double* out,
                 InstructionSet = instruction_set()) const;

  std::size_t joints() const { return count_; }

  /// A signal of the table, interpolated linearly.
  double along(const RecordedSignal&, double time) const;
  const MotionTable& table() const { return motion_.table; }

 private:
  /// position + velocity s + acceleration s^2/2 + jerk s^3/6, s = time - start.
  struct Phase {
    double start = 0, position = 0, velocity = 0, acceleration = 0, jerk = 0;
  };
  /// Moves as polynomials: one sequence from the center, then a cycle from the end of the last move.
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
  Eigen::MatrixXd slopes_;                              // of the table at its rows
  std::vector<std::vector<Oscillation>> oscillations_;  // of each joint, in the format of the kernels
  std::vector<Moves> moves_;
  std::size_t count_ = 0;
};

}  // namespace qerr
