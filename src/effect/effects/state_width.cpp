#include <cmath>
#include <numbers>

#include "effect/effects/effects.hpp"
#include "encoder/loop_reading.hpp"

namespace qerr {

namespace {

/// Displacement of the edges of the second channel [rad or m].
double displacement(const Effect& e, const Encoder& encoder) {
  return e.number("phase") / (2 * std::numbers::pi) * encoder.resolution * encoder.counts_per_period;
}

/// Edges lie at (k - 1/2) Delta, or at k Delta of an encoder that rounds down; those with odd k belong to the
/// second channel. Between two edges the position is stretched, so that the ideal quantizer that follows
/// switches where the displaced edges are.
Action action(const Effect& e, const Encoder& encoder, std::uint64_t) {
  const double step = encoder.resolution, shift = displacement(e, encoder) / step;
  if (shift == 0) return [](double x, const Moment&) { return x; };
  const double edge = below_reading(encoder);
  return [=](double x, const Moment&) {
    // Two counts make a period of the pattern: an edge of the first channel at 0, of the second at 1 + shift,
    // in units of the step.
    const double position = x / step + edge, base = 2 * std::floor(position / 2);
    const double within = position - base;
    const double stretched =
        within < 1 + shift ? within / (1 + shift) : 1 + (within - 1 - shift) / (1 - shift);
    return (base + stretched - edge) * step;
  };
}

/// Two states of widths Delta + s and Delta - s, whose middles lie s/2 beyond the counts' positions: mean
/// -s/2, variance ((Delta + s)^3 + (Delta - s)^3)/(24 Delta) = Delta^2/12 + s^2/4, bounded by -Delta/2 - s.
/// It changes with every count, as the quantization error does, and is treated as white like it.
std::optional<Share> share(const Effect& e, const Encoder& encoder, const Usage&) {
  const double s = displacement(e, encoder);
  return Share{0.0 - 0.5 * s, 0.5 * std::abs(s), 0.5 * std::abs(s), Spectrum::white};
}

}  // namespace

EffectKind state_width_effect() {
  return {.name = "state_width",
          .summary = "unequal quadrature states",
          .typical = "tens of electrical degrees on cheap discs",
          .stage = Stage::line,
          .parameters = {{.name = "phase",
                          .dimension = dimension::angle,
                          .meaning = "quadrature error, electrical",
                          .required = true,
                          .least = -1.5,
                          .most = 1.5}},
          .action = action,
          .share = share,
          .in_loop =
              [](const Effect& e, const Encoder& encoder, LoopReading& r) {
                const double shift = std::abs(displacement(e, encoder)) / encoder.resolution;
                r.excess += 0.5 * shift;
                r.narrowest_state -= shift;
              },
          .encoder_need = EncoderNeed{.least = 4,
                                      .most = 4,
                                      .why = "unequal states are modelled only for four counts per period",
                                      .remedy = "decoding: x4; for a sine/cosine encoder subdivision_error"},
          .scattering =
              Scattering{.parameter = "phase",
                         .possible =
                             [](const RecordSignals& s) {
                               return s.counted && !s.is_stationary() && s.encoder.counts_per_period == 4;
                             },
                         .of_displacement =
                             [](double distance, const Encoder& e) {
                               return distance / (e.counts_per_period * e.resolution) * 2 * std::numbers::pi;
                             }},
          .remedy = {true, "count whole lines where that is fine enough, or adjust the channels' phase"}};
}

}  // namespace qerr
