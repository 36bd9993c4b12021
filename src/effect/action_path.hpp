#pragma once

#include <vector>

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

}  // namespace qerr
