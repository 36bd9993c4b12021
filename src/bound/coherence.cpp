#include "qerr/bound/coherence.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "qerr/bound/noise_in_motion.hpp"

namespace qerr {

namespace {

bool whole(double x, double samples) { return std::abs(std::remainder(x, 1.0)) * samples <= 1; }

/// Is (p, s) a coincidence that is no multiple of a smaller one?
bool fundamental(int p, int s, double first, double second, double samples) {
  const int common = std::gcd(p, s);
  for (int divisor = common; divisor > 1; --divisor)
    if (common % divisor == 0 && whole((p / divisor) * first + (s / divisor) * second, samples)) return false;
  return whole(p * first + s * second, samples);
}

}  // namespace

CoherentSigma coherent_sigma(const Autocorrelation& a, std::span<const MovingEncoder> encoders, int most,
                             double samples) {
  CoherentSigma result;
  std::vector<double> sigma;
  double variance = 0, spread = 0;
  for (const MovingEncoder& e : encoders) {
    sigma.push_back(constant_speed_sigma(a, e.speed));
    variance += std::pow(e.weight * sigma.back(), 2);
  }
  const double negligible = 1e-18 * a.r[0];
  for (std::size_t i = 0; i < encoders.size(); ++i)
    for (std::size_t j = i + 1; j < encoders.size(); ++j) {
      const double weights = 2 * std::abs(encoders[i].weight * encoders[j].weight);
      double of_pair = 0;
      for (int p = 1; p <= most; ++p)
        for (int s = 1; s <= most; ++s)
          for (const int sign : {-1, 1}) {
            if (!fundamental(p, s, encoders[i].speed, sign * encoders[j].speed, samples)) continue;
            const double shared = std::pow(constant_speed_sigma(a, p * encoders[i].speed), 2);
            if (!(weights > 0) || shared <= negligible) continue;
            result.coincidences.push_back({i, j, p, s, sign, weights * shared / (p * s)});
            of_pair += result.coincidences.back().cross_term;
          }
      spread += std::min(of_pair, weights * sigma[i] * sigma[j]);
    }
  result.sigma = std::sqrt(variance);
  result.lowest = std::sqrt(std::max(0.0, variance - spread));
  result.highest = std::sqrt(variance + spread);
  return result;
}

}  // namespace qerr
