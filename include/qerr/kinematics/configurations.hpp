#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>
#include <vector>

#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

enum class SamplingMethod {
  sobol,   ///< low-discrepancy points, digitally shifted by the seed
  random,  ///< independent uniform points
  grid,    ///< `count` equally spaced values a joint, both ends included; the last joint runs fastest
  list     ///< the given points (methods `list` and `file` of the spec)
};

/// The configurations over which statistics are taken. Configuration i depends on the method, the seed and i
/// alone.
struct Configurations {
  SamplingMethod method = SamplingMethod::sobol;
  std::uint64_t count = 10000;  ///< points in all; of a grid, values per joint
  std::uint64_t seed = 1;
  std::vector<Limits> ranges;                ///< one per independent joint [rad or m]
  std::vector<Eigen::VectorXd> points = {};  ///< of a list
};

/// How many configurations there are; a grid has count^joints. Saturates at 2^63 - 1.
std::uint64_t size(const Configurations&);

/// The digit-th of `count` equally spaced values of a range; a single one stands in the middle [rad or m].
double grid_value(const Limits& range, std::uint64_t digit, std::uint64_t count);

/// Configurations first .. first + count - 1 as columns.
/// @returns independent joints x count [rad or m]
Eigen::MatrixXd draw(const Configurations&, std::uint64_t first, std::uint64_t count);

}  // namespace qerr
