#pragma once

#include "filter/frequency_response.hpp"
#include "qerr/filter/quality.hpp"

namespace qerr {

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

}  // namespace qerr
