#pragma once

namespace qerr {

/// Fisher information of one quantized reading x + noise, averaged over the position in a count.
///
/// With P_k(x) the probability of the count k, z the distances of its edges in units of the noise and phi the
/// normal density,
///   I_x = 1/s^2 integral_0^1 sum_k (phi(z_k) - phi(z_k+1))^2 / P_k dx,
///   I_log s = integral_0^1 sum_k (z_k phi(z_k) - z_k+1 phi(z_k+1))^2 / P_k dx.
struct ReadingInformation {
  double position = 0;   ///< of the position [1/count^2]
  double log_sigma = 0;  ///< of the logarithm of the noise's standard deviation
};

/// @param noise  of the reference, standard deviation s [counts], > 0
ReadingInformation reading_information(double noise);

}  // namespace qerr
