#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "qerr/filter/autocorrelation.hpp"

namespace qerr {

/// One encoder's part of an operational coordinate at constant speed.
struct MovingEncoder {
  double weight = 0;  ///< (J C)_i Delta_i [m or rad]
  double speed = 0;   ///< V_i [quanta per sample]
};

/// first_multiple V_first + sign second_multiple V_second is a whole number: harmonics of the two errors fall
/// together.
struct Coincidence {
  std::size_t first = 0, second = 0;
  int first_multiple = 1, second_multiple = 1;
  int sign = -1;
  double cross_term = 0;  ///< largest |contribution| to the variance, over the zeros of the encoders
};

/// Sigma of a filtered coordinate when several encoders move at constant speeds.
struct CoherentSigma {
  double sigma = 0;  ///< sqrt(sum weight_i^2 sigma_i^2): root mean square over independent zeros
  double lowest = 0, highest = 0;  ///< a single run lies between
  std::vector<Coincidence> coincidences;
};

/// Harmonic k_i of encoder i has the frequency k_i V_i. Where no k_i V_i +- k_j V_j is whole the variances
/// add (for every run). Where p V_i +- s V_j is, the multiples of (p, s) interfere: with the phase psi of the
/// zeros the term
/// (+-w_i w_j / (p s)) sum_l |H(e^{2 pi i l p V_i})|^2/(pi l)^2 cos(2 pi l psi) is added, whose mean over psi
/// is zero and whose modulus is at most 2 |w_i w_j| sigma^2(p V_i)/(p s), reached at psi = 0 (and at most 2
/// |w_i w_j| sigma_i sigma_j for all coincidences of a pair).
///
/// Equal speeds are the common case (p = s = 1): the errors of two joints in step can add up fully.
/// @param most_multiple  p and s are searched up to here; the terms left out are smaller than 1/(p s)
/// @param samples        length of the run; multiples that beat more slowly than once in it count as
/// coinciding
CoherentSigma coherent_sigma(const Autocorrelation&, std::span<const MovingEncoder>, int most_multiple = 8,
                             double samples = 1e4);

}  // namespace qerr
