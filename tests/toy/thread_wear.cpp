#include <cmath>

#include "effect/effects/effects.hpp"
#include "qerr/effect/effect_kind.hpp"

/// An effect of the tests alone: the file that a new effect needs, beside one line in the list.
namespace qerr {

namespace {

/// A lead screw worn evenly from one end to the other: the error grows with the square of the position.
std::vector<Term> terms(const RecordSignals& s) {
  if (s.is_stationary()) return {};
  return {linear_term(s, "thread_wear", s.path.square(),
                      [](Effect& e, const Eigen::VectorXd& c) { e.numbers["curvature"] = c[0]; })};
}

std::optional<Share> share(const Effect& e, const Encoder&, const Usage& u) {
  if (e.number("curvature") == 0) return Share{};
  if (!u.position) return std::nullopt;
  const double most = e.number("curvature") * u.position->largest() * u.position->largest();
  return Share{0.5 * most, 0.5 * std::abs(most), 0.5 * std::abs(most), Spectrum::motion};
}

}  // namespace

EffectKind thread_wear_effect() {
  return {.name = "thread_wear",
          .summary = "error in proportion to the square of the position",
          .typical = "none: an effect of the tests",
          .stage = Stage::disc,
          .parameters = {{.name = "curvature", .meaning = "error per squared position", .required = true}},
          .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
            return [c = e.number("curvature")](double x, const Moment&) { return x + c * x * x; };
          },
          .share = share,
          .need = Need::position,
          .terms = terms,
          .twins = {{"scale", "a motion to both sides of the zero"}},
          .table = TableShape{.linear = true},
          .remedy = {true, "replace the screw"}};
}

}  // namespace qerr
