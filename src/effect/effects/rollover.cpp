#include <cmath>

#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

/// Into [-modulus/2, modulus/2), as a counter of two's complement does.
double wrapped(double count, double modulus) { return count - modulus * std::floor(count / modulus + 0.5); }

/// The reading lacks k spans while the position is within half a span of k spans.
std::optional<Share> share(const Effect& e, const Encoder& encoder, const Usage& u) {
  if (!u.position) return std::nullopt;
  const double span = e.number("modulus") * encoder.resolution, step = encoder.resolution;
  const double low = std::floor((u.position->lower - step) / span + 0.5);
  const double high = std::floor((u.position->upper + step) / span + 0.5);
  if (low == 0 && high == 0) return Share{};
  const double half = 0.5 * (high - low) * span;
  // For a uniform position, every number of lost spans is equally probable. With at most three spans the
  // largest deviation is used: the position may be at the extremes all the time.
  return Share{-0.5 * (high + low) * span, half, high - low > 3 ? half / std::sqrt(3.0) : half,
               Spectrum::motion};
}

}  // namespace

EffectKind rollover_effect() {
  return {.name = "rollover",
          .summary = "the counter overflows and wraps around",
          .typical = "jumps of 2^16 or 2^32 counts",
          .stage = Stage::decoder,
          .parameters = {{.name = "modulus",
                          .kind = Kind::integer,
                          .meaning = "counts at which it wraps",
                          .required = true,
                          .least = 2,
                          .most = 0x1p53 - 1}},  // 2^53 is also what 2^53 + 1 is read as
          .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [modulus = e.number("modulus")](double x, const Moment&) { return wrapped(x, modulus); };
          },
          .share = share,
          .need = Need::position,
          .jumps = true,
          .remedy = {false, "unwrap the counter in its driver, or use a wider one"}};
}

}  // namespace qerr
