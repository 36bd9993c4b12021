#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>
#include <vector>

#include "qerr/kinematics/chain.hpp"
#include "qerr/kinematics/robot_model.hpp"

namespace qerr {

enum class SamplingMethod {
  sobol,   ///< low-discrepancy points, digitally shifted by the seed
  random,  ///< independent uniform points
  grid,    ///< `count` equally spaced values per joint, both ends included; the last joint varies fastest
  list     ///< the given points (methods `list` and `file` of the spec)
};

/// The configurations over which statistics are computed. Configuration i depends only on method, seed and i.
struct Configurations {
  SamplingMethod method = SamplingMethod::sobol;
  std::uint64_t count = 10000;  ///< number of points; of a grid, values per joint
  std::uint64_t seed = 1;
  std::vector<Limits> ranges;                ///< one per independent joint [rad or m]
  std::vector<Eigen::VectorXd> points = {};  ///< of method list
};

/// Joints for which Sobol's sequence is tabulated (Joe and Kuo, in Boost).
inline constexpr std::size_t most_sobol_joints = 3667;

/// Number of configurations; count^joints for a grid. Saturates at 2^63 - 1.
std::uint64_t size(const Configurations&);

/// Value `digit` of `count` equally spaced values of a range, the middle for count 1 [rad or m].
double grid_value(const Limits& range, std::uint64_t digit, std::uint64_t count);

/// Configurations first .. first + count - 1 as columns.
/// @returns independent joints x count [rad or m]
Eigen::MatrixXd draw(const Configurations&, std::uint64_t first, std::uint64_t count);

/// Bound of the distance of the tip from the origin of the base, over the given ranges of the joints [m].
double reach(const Chain&, const Configurations&);

}  // namespace qerr
