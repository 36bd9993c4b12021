#include <cmath>

#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind log_rounding_effect() {
  return {.name = "log_rounding",
          .summary = "log resolution",
          .typical = "the last decimal: 1e-4 rad in a log of four",
          .stage = Stage::log,
          .parameters = {{.name = "step",
                          .meaning = "resolution of the logged positions",
                          .required = true,
                          .least = 0,
                          .most = largest_error,
                          .coordinate = true}},
          .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [step = e.number("step")](double x, const Moment&) {
              return step == 0 ? x : step * std::floor(x / step + 0.5);
            };
          },
          .share = [](const Effect& e, const Encoder&, const Usage&) -> std::optional<Share> {
            const double step = e.number("step");
            return Share{0, step / 2, step / std::sqrt(12.0), Spectrum::white};
          },
          .remedy = {false, "nothing to compensate in the robot: write the log with more digits"}};
}

}  // namespace qerr
