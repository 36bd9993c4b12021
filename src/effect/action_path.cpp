#include "effect/action_path.hpp"

#include <algorithm>

#include "effect/effects/periodic.hpp"

namespace qerr {

void ActionPath::add(const EffectKind& kind, Action action) {
  const auto sums = [&](const Step& s) { return is_periodic(*s.kind) && s.kind->stage == kind.stage; };
  const auto sum = is_periodic(kind) ? std::ranges::find_if(steps_, sums) : steps_.end();
  if (sum != steps_.end())
    sum->actions.push_back(std::move(action));
  else
    steps_.push_back({&kind, {std::move(action)}});
}

double ActionPath::operator()(double signal, const Moment& m) const {
  for (const Step& step : steps_) {
    const double before = signal;
    signal = step.actions.front()(before, m);
    for (std::size_t i = 1; i < step.actions.size(); ++i) signal += step.actions[i](before, m) - before;
  }
  return signal;
}

}  // namespace qerr
