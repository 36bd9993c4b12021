#pragma once

#include <complex>
#include <vector>

#include "filter/norms/multiprecision.hpp"
#include "qerr/filter/filter.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

/// H(e^{j 2 pi f T}) of one filter at many frequencies f.
///
/// With w = j s/c, s = sin(pi f T), c = cos(pi f T), a section is the ratio of b0 c^2 - b2 s^2 + j b1 s c to
/// the same of a: no singularity at half the sample rate, and the relative accuracy of Number for any f T.
/// @tparam Number  double, or DoubleDouble where 1 - |H| has to keep its digits
template <class Number>
class FrequencyResponse {
 public:
  explicit FrequencyResponse(const Filter&);

  ComplexOf<Number> at(double frequency_hz) const;  ///< H [1/s^derivative]
  /// H/(j 2 pi f)^derivative, 1 for an ideal derivative. @pre f > 0
  ComplexOf<Number> over_ideal(double frequency_hz) const;

 private:
  struct NumberSection {
    bool second = false;
    Number b[3], a[3];
  };
  /// H/(j omega)^divisions: a division after each factor, so that neither leaves the range of Number.
  ComplexOf<Number> product(double frequency_hz, int divisions) const;

  double sample_rate_ = 0;
  int derivative_ = 0;
  Number gain_{};
  std::vector<NumberSection> sections_;
  int differences_ = 0;  // zeros of the taps at z = 1, divided out: at low frequencies their sum would cancel
  std::vector<Number> taps_;
};

extern template class FrequencyResponse<double>;
extern template class FrequencyResponse<DoubleDouble>;

/// |H/(j 2 pi f)^d - 1| of one filter at many frequencies, with 12 digits however small it is: in doubles,
/// and in double-double where these would lose more than three digits.
class TrackingError {
 public:
  explicit TrackingError(const Filter& filter) : quick_(filter), fine_(filter) {}
  double operator()(double frequency_hz) const;
  Fidelity fidelity(double frequency_hz) const;

 private:
  FrequencyResponse<double> quick_;
  FrequencyResponse<DoubleDouble> fine_;
};

/// Poles and zeros of a filter's sections in w, both of each pair.
struct Corners {
  std::vector<std::complex<double>> zeros, poles;
  double slowest_pole = 1;  ///< smallest |w|, at most 1
};

Corners corners(const Filter&);

/// The limit of H/(j 2 pi f)^derivative at 0 Hz, with its sign: 1 for a filter that estimates its derivative,
/// infinite for one that passes a lower derivative, 0 for one that passes only higher ones.
///
/// Zeros 1e12 times slower than the slowest pole count as zeros at 0 Hz.
double limit_at_dc(const Filter&);

}  // namespace qerr
