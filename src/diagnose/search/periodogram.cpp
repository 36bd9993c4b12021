#include "diagnose/search/periodogram.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace qerr {

std::vector<float> periodogram(const Eigen::ArrayXd& score, const Eigen::ArrayXd& argument, double spacing,
                               Eigen::Index first, Eigen::Index last) {
  // Four cells or more in the period of the highest rate.
  const auto cells = std::bit_ceil(static_cast<std::size_t>(4 * std::max<Eigen::Index>(last, 4)));
  const double cells_per_unit = spacing * static_cast<double>(cells) / (2 * std::numbers::pi);
  std::vector<float> grid(cells, 0.0F);
  for (Eigen::Index k = 0; k < score.size(); ++k) {
    const double place = argument[k] * cells_per_unit, cell = std::floor(place), x = place - cell;
    const double y = 1 - x;
    // The cubic B-spline at the four cells about the place, the second of which is the one at or before it.
    const double weights[4] = {y * y * y / 6, (4 - 6 * x * x + 3 * x * x * x) / 6,
                               (4 - 6 * y * y + 3 * y * y * y) / 6, x * x * x / 6};
    for (std::size_t i = 0; i < 4; ++i)
      grid[(static_cast<std::size_t>(cell) + i + cells - 1) % cells] +=
          static_cast<float>(score[k] * weights[i]);
  }
  Eigen::FFT<float> transform;
  transform.SetFlag(Eigen::FFT<float>::HalfSpectrum);
  std::vector<std::complex<float>> spectrum;
  transform.fwd(spectrum, grid);
  std::vector<float> powers;
  for (Eigen::Index n = first; n <= last; ++n) {
    // Of the spline, the transform is sinc^4.
    const double u = std::numbers::pi * static_cast<double>(n) / static_cast<double>(cells);
    const double spline = u > 0 ? std::pow(std::sin(u) / u, 4) : 1;
    powers.push_back(std::norm(spectrum[static_cast<std::size_t>(n)]) / static_cast<float>(spline * spline));
  }
  return powers;
}

double power_at(const Eigen::ArrayXd& score, const Eigen::ArrayXd& argument, double rate) {
  double cosine = 0, sine = 0;
  for (Eigen::Index k = 0; k < score.size(); ++k) {
    cosine += score[k] * std::cos(rate * argument[k]);
    sine += score[k] * std::sin(rate * argument[k]);
  }
  return cosine * cosine + sine * sine;
}

}  // namespace qerr
