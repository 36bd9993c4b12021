#pragma once

#include <string>
#include <vector>

#include "diagnose/surrogates/surrogate.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// How a statistic scatters when nothing is wrong, by which it gets its tail.
enum class Tail {
  both_sides,  ///< about a mean, nearly Gaussian
  chi_squared  ///< a length: its square is a sum of `degrees` squares
};

/// A number that residuals of one encoder are reduced to, of the record and of every surrogate.
struct ResidualStatistic {
  std::string name;
  Tail tail = Tail::both_sides;
  int degrees = 1;
  double least = 0.01;    ///< scatter that is always allowed for: paths are known that well and no better
  Eigen::ArrayXd values;  ///< of the record, then of every surrogate
};

/// Statistics of measured - reference, in counts (ratios and correlations without unit):
///
/// - mean (not of an encoder whose zero is free, whose mean is taken off everything else);
/// - sigma_ratio, to Delta/sqrt 12; uniformity, the largest distance of its distribution from that of the
///   quantization error;
/// - autocorrelation, of neighbouring readings, and autocorrelation_smooth, of means over 16;
/// - by_direction, by_time (difference of means between the sides, the halves), by_speed, by_effort (rms of
///   what follows them), by_angle (amplitude of the encoder shaft's first order), by_count (rms of the means
///   of the four quadrature states);
/// - velocity_sigma of each of the spec's first derivatives, in Delta ||H||_2/sqrt 12, where the record is
///   evenly stamped at its rate.
/// @param surrogates  how many
std::vector<ResidualStatistic> residual_statistics(const Evidence&, const std::vector<Filter>&,
                                                   Eigen::Index surrogates, std::uint64_t seed,
                                                   unsigned threads, InstructionSet = instruction_set());

}  // namespace qerr
