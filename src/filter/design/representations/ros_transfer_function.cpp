#include "filter/design/representations/representations.hpp"

namespace qerr {
namespace {

/// Errors of filter_from_coefficients name numerator and denominator; the keys of ROS are b and a.
Filter build(const std::map<std::string, Rows>& values, double sample_rate, int derivative) {
  try {
    return filter_from_coefficients(flat(values.at("b"), "b"), flat(values.at("a"), "a"), sample_rate,
                                    derivative);
  } catch (const Error& e) {
    std::vector<Fault> faults = e.faults();
    for (Fault& fault : faults) {
      if (fault.key == "numerator") fault.key = "b";
      if (fault.key == "denominator") fault.key = "a";
    }
    throw Error(faults, e.trouble());
  }
}

}  // namespace

FilterRepresentation ros_transfer_function_representation() {
  return {
      "ros_transfer_function",
      "in place of lowpass: an unchanged entry of a ROS filter chain, a[0] y_k = sum b[i] x_(k-i) - sum "
      "a[i] y_(k-i)",
      key::object("params", "a and b of a ROS transfer function filter"),
      {key::numbers("a", "denominator in ascending powers of z^-1").needed(),
       key::numbers("b", "numerator in ascending powers of z^-1").needed()},
      {key::choice("type",
                   "filters/TransferFunctionFilterDouble|filters/MultiChannelTransferFunctionFilterDouble",
                   "of the ROS filter")
           .needed(),
       key::text("name", "of the ROS filter; not used")},
      build};
}

}  // namespace qerr
