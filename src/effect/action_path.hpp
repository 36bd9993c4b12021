#pragma once

#include <vector>

#include "qerr/effect/effect_kind.hpp"

namespace qerr {

/// The actions of effects, one after another. Periodic errors of one stage are the Fourier series of one
/// angle: each acts at the angle before them all, and they add.
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
