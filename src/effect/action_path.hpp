#pragma once

#include <string>
#include <vector>

#include "encoder/loop_reading.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

/// Whether one effect acts before another, wherever they stand in a spec: by stage, and within a stage what
/// `first_in_stage` says, then periodic errors, which are stated at the angle that the disc or gear has, then
/// the others, such as an offset that the counter adds. Those of the decoder act in the order of the
/// catalogue: counts are lost before a wrong decoding multiplies them and an overflow wraps them.
bool acts_before(const EffectKind&, const EffectKind&);

/// The actions of effects in the order of `acts_before`; of equal ones in that of `add`. Periodic errors of
/// one stage are the Fourier series of one angle: each acts at the angle before them all, and they add.
class ActionPath {
 public:
  void add(const EffectKind&, Action);
  bool empty() const { return steps_.empty(); }
  double operator()(double signal, const Moment&) const;

 private:
  struct Step {
    const EffectKind* kind;
    std::vector<Action> actions;
  };
  std::vector<Step> steps_;
};

/// Adds what an effect of an encoder makes of a reading that closes a loop: by its row's `in_loop`, else of
/// an error that depends on the position alone, of which the row's table has the period, half width and
/// slope. A bounded error otherwise adds nothing.
void add_to_reading(const Effect&, const Encoder&, LoopReading&);

/// By what the effects of a joint behind a stage multiply an error that its encoder's reading has there.
double multiplied_behind(Stage, const std::string& joint, const std::vector<Effect>&, const Encoder&);

}  // namespace qerr
