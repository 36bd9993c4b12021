#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/filter/filter.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr {

/// Position of an encoder along a record [counts]: range, first value, and the length of the path.
struct Travel {
  double lower = 0, upper = 0, start = 0, length = 0;
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

/// sigma of the filtered quantization error of each encoder along a motion, in quantization intervals:
///
///     sigma^2 = mean over the encoder's zero u in a count, and over the samples n of the record, of y_n^2,
///     y = filter of e_n = [x_n + u] - x_n - u, x_n the encoder's position in counts,
///
/// without the assumption IPQN. As in a simulation, the filter starts in the steady state of e_0, and samples
/// before `settling` do not count. The mean over u is that of 32 to 4096 equally spaced values (of those at
/// which the record crosses an edge, if that are not all: for the others it is known), as many as cross
/// 131072 edges together, which brings it within 0.2 % of its limit.
/// Behind effects on the decoder, y is the filter of the error less its mean over u.
/// @param effects   that displace what is rounded or change its counts; none that are random
/// @param settling  initial part that is excluded [s]
/// @returns one per encoder; empty if the record has more than `longest_record` samples
std::optional<Eigen::VectorXd> sigma_along_motion(const OperationalModel&, const std::vector<Effect>& effects,
                                                  const Motion&, const Filter&, double settling);

}  // namespace qerr
