#include <cmath>

#include "filter/design/families/tracking.hpp"

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
    throw Error(Fault{{},
                      group == 2 ? "kp" : "bandwidth",
                      "the loop is not stable at the sample rate: it needs 2 kp T + ki T^2 < 4",
                      "kp T " + figure(alpha) + ", ki T^2 " + figure(static_cast<double>(beta)),
                      "use smaller gains, or a higher sample rate"});
  return tracking_filter(wanted, {beta, DoubleDouble(2 * alpha), rest});
}

}  // namespace

FilterFamily tracking_loop_family() {
  return {
      "tracking_loop",
      "estimates position or velocity itself, as drives (ODrive, VESC, moteus) do: the prediction x + T v, "
      "with the residual r, is corrected by x += T kp r, v += T ki r; kp = 2 damping bandwidth, ki = "
      "bandwidth^2; v is late by about kp/ki under acceleration",
      {{.name = "bandwidth",
        .dimension = dimension::angular_speed,
        .meaning = "natural frequency of the loop, in rad/s",
        .least = 0,
        .open_below = true},
       {.name = "damping",
        .meaning = "damping ratio; 1, critical, if absent",
        .least = 0,
        .open_below = true},
       {.name = "kp", .meaning = "in place of bandwidth [1/s]", .least = 0, .open_below = true},
       {.name = "ki", .meaning = "with kp [1/s^2]", .least = 0, .open_below = true}},
      design};
}

}  // namespace qerr
