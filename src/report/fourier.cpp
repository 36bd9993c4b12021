#include "report/fourier.hpp"

#include <unsupported/Eigen/FFT>

namespace qerr {

std::vector<std::complex<double>> half_spectrum(const std::vector<double>& values) {
  Eigen::FFT<double> transform;
  transform.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  std::vector<std::complex<double>> spectrum;
  transform.fwd(spectrum, values);
  return spectrum;
}

}  // namespace qerr
