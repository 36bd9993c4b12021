#include <cmath>
#include <numbers>

#include "effects.hpp"

namespace qerr {

EffectKind clock_drift_effect() {
  return {"clock_drift",
          "the encoder's clock runs fast or slow against the reference's",
          "10 to 100 ppm between two crystals",
          Stage::clock,
          {{.name = "rate", .meaning = "relative rate error", .required = true, .least = -1, .most = 1}},
          [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [rate = e.number("rate")](double t, const Moment& m) { return t + rate * m.time; };
          },
          [](const Effect& e, const Encoder&, const Usage& u) {
            const double latest = std::abs(e.number("rate")) * u.duration;
            return Share{0, latest * u.largest_speed, latest * u.rms_speed / std::numbers::sqrt3};
          }};
}

}  // namespace qerr
