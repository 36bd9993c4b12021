#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "qerr/bound/operational_error.hpp"
#include "qerr/effect/effect.hpp"
#include "qerr/filter/filter.hpp"
#include "qerr/simulate/motion.hpp"

namespace qerr {

/// Number of positions of an encoder's zero, equally spaced over a count, over which `sigma_along_motion` and
/// `sigma_exact` of a simulation take the mean: 16 to 256, a multiple of 8, fewer for longer records, which
/// are themselves means over many positions within a count.
std::uint64_t zeros_along_motion(std::uint64_t samples);

/// sigma of the filtered quantization error of each encoder along a motion, in quantization intervals:
///
///     sigma^2 = mean over the encoder's zero u in a count, and over the samples n of the record, of y_n^2,
///     y = filter of e_n = [x_n + u] - x_n - u, x_n the encoder's position in counts,
///
/// without the assumption IPQN. As in a simulation, the filter starts in the steady state of e_0, and samples
/// before `settling` do not count. The mean over u is that of N equally spaced values (`zeros_along_motion`).
/// At rest its relative error is at most 1/N^2 of a filter without derivative; in motion it is smaller, as
/// successive samples differ in their position within a count.
/// @param effects   that displace what is rounded: neither random nor behind the quantizer
/// @param settling  initial part that is excluded [s]
/// @returns one per encoder; empty if the record has more than `longest_record` samples at the filter's rate
std::optional<Eigen::VectorXd> sigma_along_motion(const OperationalModel&, const std::vector<Effect>& effects,
                                                  const Motion&, const Filter&, double settling);

/// Longest record of `sigma_along_motion` [samples]: a second of computing an encoder.
inline constexpr double longest_record = 2e7;

}  // namespace qerr
