
#include "filter/design/families/families.hpp"

namespace qerr {
namespace {

Filter design(const FilterDesign& wanted) {
  check_sample_rate(wanted.sample_rate);
  const std::size_t group = parameter_group(wanted, {{"bandwidth"}, {"bandwidth", "damping"}, {"kp", "ki"}});
  const double period = 1 / wanted.sample_rate;
  double kp = 0, ki = 0;
  if (group == 2) {
    kp = checked_number(wanted, "kp", 0, 1e12);
    ki = checked_number(wanted, "ki", 0, 1e24);
  } else {
    const double bandwidth = checked_number(wanted, "bandwidth", 0, 1e12);
    kp = 2 * checked_number(wanted, "damping", 0, 1e6, 1.0) * bandwidth;
    ki = bandwidth * bandwidth;
  }
  const double alpha = kp * period;
  const DoubleDouble beta = DoubleDouble(ki) * DoubleDouble(period) * DoubleDouble(period);
  const DoubleDouble rest = DoubleDouble(4) - DoubleDouble(2 * alpha) - beta;
  if (!(rest.hi > 4e-16))
    throw Error(group == 2 ? "kp" : "bandwidth",
                "the loop is not stable at the sample rate: it needs 2 kp T + ki T^2 < 4",
                "kp T " + figure(alpha) + ", ki T^2 " + figure(static_cast<double>(beta)),
                "use smaller gains, or a higher sample rate");
  return tracking_filter(wanted, {beta, DoubleDouble(2 * alpha), rest});
}

}  // namespace

FilterFamily tracking_loop_family() {
  return {
      "tracking_loop",
      "estimates position or velocity itself, as drives (ODrive, VESC, moteus) do: the prediction x + T v, "
      "with the residual r, is corrected by x += T kp r, v += T ki r; kp = 2 damping bandwidth, ki = "
      "bandwidth^2; v is late by about kp/ki under acceleration",
      {key::number("bandwidth", "natural frequency of the loop, in rad/s", dimension::angular_speed).above(0),
       key::number("damping", "damping ratio; 1, critical, if absent").above(0),
       key::number("kp", "in place of bandwidth [1/s]").above(0),
       key::number("ki", "with kp [1/s^2]").above(0)},
      design};
}

}  // namespace qerr
