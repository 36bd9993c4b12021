#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "qerr/core/instruction_set.hpp"
#include "qerr/simulate/motion.hpp"

namespace qerr {

struct Oscillation;

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

}  // namespace qerr
