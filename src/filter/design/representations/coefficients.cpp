#include "filter/design/representations/representations.hpp"

namespace qerr {
namespace {

Filter build(const std::map<std::string, Rows>& values, double sample_rate, int derivative) {
  const auto a = values.find("denominator");
  return filter_from_coefficients(
      flat(values.at("numerator"), "numerator"),
      a == values.end() ? std::vector<double>{1.0} : flat(a->second, "denominator"), sample_rate, derivative);
}

}  // namespace

FilterRepresentation coefficients_representation() {
  return {"coefficients",
          "in place of lowpass: numerator and denominator of a transfer function, b and a of "
          "scipy.signal.lfilter",
          key::numbers("numerator", "coefficients in ascending powers of z^-1"),
          {},
          {key::numbers("denominator", "coefficients in ascending powers of z^-1")},
          build};
}

}  // namespace qerr
