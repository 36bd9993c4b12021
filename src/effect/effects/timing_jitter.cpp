#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind timing_jitter_effect() {
  return {"timing_jitter",
          "samples are taken off their stamps",
          "1 to 2 ms from a desktop computer, microseconds from a real-time one",
          Stage::clock,
          {{.name = "sigma",
            .dimension = dimension::time,
            .meaning = "standard deviation of the sampling instant",
            .required = true,
            .least = 0}},
          [](const Effect& e, const Encoder&, std::uint64_t seed) -> Action {
            return [sigma = e.number("sigma"), seed](double t, const Moment& m) {
              return sigma == 0 ? t : t + sigma * normal(seed, m.index);
            };
          },
          [](const Effect& e, const Encoder&, const Usage& u) -> std::optional<Share> {
            const double sigma = e.number("sigma");
            if (sigma == 0) return Share{};
            if (!u.velocity) return std::nullopt;
            return Share{0, 4 * sigma * u.velocity->largest(), sigma * u.velocity->rms(), Course::white};
          },
          Need::velocity};
}

}  // namespace qerr
