#include <cmath>
#include <numbers>

#include "effect/effects/effects.hpp"

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
          [](const Effect& e, const Encoder&, const Usage& u) -> std::optional<Share> {
            if (e.number("rate") == 0) return Share{};
            if (!u.duration || !u.velocity) return std::nullopt;
            // rate t v(t): t is spread evenly, and has nothing to do with v.
            const double latest = std::abs(e.number("rate")) * *u.duration;
            return Share{0,
                         latest * u.velocity->largest(),
                         latest * u.velocity->rms() / std::numbers::sqrt3,
                         Course::motion,
                         {},
                         u.velocity->rate};
          },
          Need::duration};
}

}  // namespace qerr
