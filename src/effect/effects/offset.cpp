#include <cmath>

#include "effect/effects/effects.hpp"

namespace qerr {

namespace {

std::vector<Term> terms(const RecordSignals& s) {
  if (!s.encoder.zero_known) return {};
  Term t = linear_term(s, "offset", Eigen::ArrayXd::Ones(s.rows()),
                       [](Effect& e, const Eigen::VectorXd& c) { e.numbers["offset"] = c[0]; });
  t.constant = true;
  return {t};
}

/// A counter that rounds down has the same error: minus half a count.
bool is_half_a_count(const Effect& e, const RecordSignals& s) {
  return std::abs(e.number("offset") + 0.5 * direction(s.encoder) * s.step()) < 0.1 * s.step() &&
         s.encoder.rounding == Rounding::nearest;
}

}  // namespace

EffectKind offset_effect() {
  return {
      .name = "offset",
      .summary = "constant error: zero or index misplaced",
      .typical = "any; fractions of a degree after homing by hand",
      .stage = Stage::disc,
      .parameters = {{.name = "offset",
                      .meaning = "estimate minus true",
                      .required = true,
                      .least = -largest_error,
                      .most = largest_error,
                      .coordinate = true}},
      .action = [](const Effect& e, const Encoder&, std::uint64_t) -> Action {
        return [offset = e.number("offset")](double x, const Moment&) { return x + offset; };
      },
      .share = [](const Effect& e, const Encoder&, const Usage&) -> std::optional<Share> {
        return Share{e.number("offset"), 0, 0};
      },
      .terms = terms,
      .twins = {{"truncation",
                 "an absolute datum: an index pulse or a stop whose position is known to a tenth of a count",
                 is_half_a_count},
                {"backlash", "motion in both directions, with reversals"}},
      .table = TableShape{},
      .remedy = {true, "subtract it, or set the encoder's zero"}};
}

}  // namespace qerr
