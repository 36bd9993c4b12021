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

/// Position of an encoder along a record [counts]: range, first value, length of the path, and the number of
/// different positions within a count, of at most 65536.
struct Travel {
  double lower = 0, upper = 0, start = 0, length = 0, distinct = 65536;
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

/// sigma of the filtered error of each encoder along a motion, in quantization intervals:
///
///     sigma^2 = mean over the encoder's zero u in a count, and over the samples n of the record, of y_n^2,
///     y = filter of e_n = [x_n + u] - x_n - u, x_n the encoder's position in counts,
///
/// without the assumption IPQN. As in a simulation, the filter starts in the steady state of e_0, and samples
/// before `settling` do not count. The mean over u is that of 64 to 4096 zeros, one at a random place in each
/// of equal parts of a count (of the part in which the record crosses an edge, if that is not all: for the
/// others it is known).
///
/// Effects within a line make e_n = [g(x_n + u)] - x_n - u, u uniform over the whole line. With noise, y is
/// the filtered mean of the error over the noise, and the variance about it, white, is added: with s the
/// noise in counts, at V counts a sample,
///
///     sigma^2 = sum_k (w_k |H(kV)|^2 + (1 - w_k) ||H||_2^2)/(2 pi^2 k^2) + s^2 ||H||_2^2,
///     w_k = exp(-4 pi^2 k^2 s^2)
///
/// (no correlation of noise and rounding error remains in the mean over u). Jitter of the sampling instants
/// is noise of the speed's size. Behind effects on the decoder, y is the filter of the error less its mean
/// over u. The figure is within 0.5 % of that of infinitely many zeros; not so for jitter
/// where other effects change the speed at the encoder, or over a good part of a line with an error of its
/// own: it is linearized about the position, with the speed of the joint.
/// @param effects   that displace what is rounded or change its counts
/// @param settling  initial part that is excluded [s]
/// @returns one per encoder; empty if the record has more than `longest_record` samples
std::optional<Eigen::VectorXd> sigma_along_motion(const OperationalModel&, const std::vector<Effect>& effects,
                                                  const Motion&, const Filter&, double settling);

/// Part of effects within a line alone, without rounding to counts [quantization intervals].
/// @pre the record has at most `longest_record` samples
Eigen::VectorXd sigma_within_line(const OperationalModel&, const std::vector<Effect>& effects, const Motion&,
                                  const Filter&, double settling);

}  // namespace qerr
