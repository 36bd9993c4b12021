#include "effect/effects/effects.hpp"

namespace qerr {

EffectKind noise_effect() {
  return {.name = "noise",
          .summary = "white noise before the quantizer",
          .typical = "0 to 1 count",
          .stage = Stage::comparator,
          .parameters = {{.name = "sigma",
                          .meaning = "standard deviation",
                          .required = true,
                          .least = 0,
                          .most = largest_error,
                          .coordinate = true}},
          .action = [](const Effect& e, const Encoder&, std::uint64_t seed) -> Action {
            return [sigma = e.number("sigma"), seed](double x, const Moment& m) {
              return sigma == 0 ? x : x + sigma * normal(seed, m.index);
            };
          },
          .share = [](const Effect& e, const Encoder&, const Usage&) -> std::optional<Share> {
            return Share{0, 4 * e.number("sigma"), e.number("sigma"), Spectrum::white};
          },
          .scattering = Scattering{.parameter = "sigma",
                                   .deviation = [](const RecordSignals& s) -> Eigen::ArrayXd {
                                     return Eigen::ArrayXd::Ones(s.rows());
                                   },
                                   .uniform = true},
          .twins = {{"timing_jitter", "a section at standstill and sections at several speeds"}},
          .remedy = {false, "nothing to compensate: a filter, or a better sensor"}};
}

}  // namespace qerr
