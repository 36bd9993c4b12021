#include <cmath>

#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind log_rounding_effect() {
  return {"log_rounding",
          "the file's own grid",
          "the last decimal: 1e-4 rad in a log of four",
          Stage::log,
          {{.name = "step", .meaning = "step of the grid", .required = true, .least = 0, .coordinate = true}},
          [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [step = e.number("step")](double x, const Moment&) {
              return step == 0 ? x : step * std::floor(x / step + 0.5);
            };
          },
          [](const Effect& e, const Encoder&, const Usage&) -> std::optional<Share> {
            const double step = e.number("step");
            return Share{0, step / 2, step / std::sqrt(12.0), Course::white};
          }};
}

}  // namespace qerr
