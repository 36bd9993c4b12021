#pragma once

#include <string>
#include <vector>

#include "diagnose/surrogates/surrogate.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// Distribution of a statistic under the hypothesis that the model is right.
enum class Tail {
  both_sides,  ///< nearly normal about its mean
  chi_squared  ///< a norm: its square is a sum of `degrees` squares
};

/// A statistic of one encoder's residual, of the record and of every surrogate.
struct ResidualStatistic {
  std::string name;
  Tail tail = Tail::both_sides;
  int degrees = 1;
  /// Lower bound of the standard deviation that is assumed: the accuracy of the smoothed path (convention).
  double least = 0.01;
  Eigen::ArrayXd values;  ///< of the record, then of every surrogate
};

/// Statistics of measured - reference, in counts (ratios and correlations without unit):
///
/// - mean (if the encoder's zero is known; else the mean is subtracted before all other statistics);
/// - sigma_ratio, to Delta/sqrt 12;
/// - uniformity, the largest distance of the distribution function from that of the quantization error
///   (Kolmogorov);
/// - autocorrelation, of neighbouring readings, and autocorrelation_smooth, of means over 16;
/// - by_direction, by_time (difference of the means of both directions, of both halves), by_speed, by_effort
///   (rms of the part proportional to them), by_angle (amplitude of the encoder shaft's first order),
///   by_count (rms of the means of the four quadrature states);
/// - velocity_sigma of each filter of the spec for the first derivative, relative to Delta ||H||_2/sqrt 12,
///   if the record has even stamps at its rate.
/// @param surrogates  number of surrogates
std::vector<ResidualStatistic> residual_statistics(const Evidence&, const std::vector<Filter>&,
                                                   Eigen::Index surrogates, std::uint64_t seed,
                                                   unsigned threads, InstructionSet = instruction_set());

}  // namespace qerr
