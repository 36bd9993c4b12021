#include "filter/tracking_error.hpp"

#include <cmath>

namespace qerr {

double TrackingError::operator()(double f) const {
  const ComplexOf<double> h = quick_.over_ideal(f);
  const double error = std::hypot(h.re - 1, h.im);
  return error > 1e-3 ? error : fidelity(f).tracking_error;
}

Fidelity TrackingError::fidelity(double f) const {
  const ComplexDoubleDouble h = fine_.over_ideal(f);
  const DoubleDouble one = 1, error = h.re - one, square = h.im * h.im;
  // |h| - 1 = (|h|^2 - 1)/(|h| + 1)
  const DoubleDouble gain = (error * (h.re + one) + square) / (sqrt(norm(h)) + one);
  return {f, static_cast<double>(gain), std::atan2(h.im.hi, h.re.hi), std::hypot(error.hi, h.im.hi)};
}

}  // namespace qerr
