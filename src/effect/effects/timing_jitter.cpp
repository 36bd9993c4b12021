#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

std::optional<Share> share(const Effect& e, const Encoder&, const Usage& u) {
  const double sigma = e.number("sigma");
  if (sigma == 0) return Share{};
  if (!u.velocity) return std::nullopt;
  return Share{0, 4 * sigma * u.velocity->largest(), sigma * u.velocity->rms(), Spectrum::white};
}

}  // namespace

EffectKind timing_jitter_effect() {
  return {.name = "timing_jitter",
          .summary = "random difference between sampling instant and time stamp",
          .typical = "1 to 2 ms from a desktop computer, microseconds from a real-time one",
          .stage = Stage::clock,
          .parameters = {{.name = "sigma",
                          .dimension = dimension::time,
                          .meaning = "standard deviation of the sampling instant",
                          .required = true,
                          .least = 0,
                          .most = longest_delay}},
          .action = [](const Effect& e, const Encoder&, std::uint64_t seed) -> Action {
            return [sigma = e.number("sigma"), seed](double t, const Moment& m) {
              return sigma == 0 ? t : t + sigma * normal(seed, m.index);
            };
          },
          .share = share,
          .need = Need::velocity,
          .scattering = Scattering{
              .parameter = "sigma",
              .possible = [](const RecordSignals& s) { return s.ordered && s.velocity.abs().maxCoeff() > 0; },
              .deviation = [](const RecordSignals& s) { return s.velocity; }},
          .remedy = {false, "stamp the readings when they are taken, and use the stamps"}};
}

}  // namespace qerr
