#include <cmath>

#include "effect/effects/effects.hpp"
#include "encoder/loop_reading.hpp"

namespace qerr {

namespace {

/// (factor - 1) times the counted position, plus the rounding error of factor * count.
std::optional<Share> share(const Effect& e, const Encoder& encoder, const Usage& u) {
  const double factor = e.number("factor"), more = factor - 1, step = encoder.resolution;
  if (more == 0) return Share{};
  if (!u.position) return std::nullopt;
  const bool integer = factor == std::floor(factor);
  const double rounding = integer ? 0 : step;
  // The counted position differs from the true one by up to half a step (a full step if it is truncated).
  const double counted = encoder.rounding == Rounding::nearest ? 0.5 * step : step;
  return Share{more * u.position->mid_range(),
               std::abs(more) * (u.position->half_width() + counted) + 0.5 * rounding,
               std::hypot(more * u.position->rms_about_mid_range(), more * step / std::sqrt(12.0),
                          rounding / std::sqrt(12.0)),
               Spectrum::motion};
}

/// Of f [x + u] + r - x - u less its mean over u, |u| <= 1/2: (f - 1) u + f e, and the rounding r.
CountError count_error(const Effect& e) {
  const double f = e.number("factor");
  const bool integer = f == std::floor(f);
  const double factor = integer ? std::abs(f) : std::hypot(f, 1.0);
  return {factor, 0.5 * (std::abs(f - 1) + std::abs(f) - factor) + (integer ? 0 : 1)};
}

}  // namespace

EffectKind decoding_effect() {
  return {.name = "decoding",
          .summary = "counts read with the wrong decoding or counts per revolution",
          .typical = "factors 1/4, 1/2, 2, 4, -1",
          .stage = Stage::decoder,
          .parameters = {{.name = "factor",
                          .meaning = "reading over right reading, such as 0.25, 2, -1",
                          .required = true,
                          .least = -1024,
                          .most = 1024,
                          .nonzero = true}},
          .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [factor = e.number("factor")](double x, const Moment&) {
              return std::floor(factor * x + 0.5);
            };
          },
          .share = share,
          .need = Need::position,
          .count_error = count_error,
          .in_loop =
              [](const Effect& e, const Encoder&, LoopReading& r) {
                const double factor = e.number("factor");
                r.factor *= factor;
                r.count *= factor;
                if (factor != std::floor(factor)) r.rounding += 0.5;  // the product is rounded again
              },
          .remedy = {false, "set the decoding, or the counts per revolution, in the counter or in the spec"}};
}

}  // namespace qerr
