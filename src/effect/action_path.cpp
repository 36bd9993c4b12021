#include "effect/action_path.hpp"

#include <algorithm>
#include <functional>

#include "effect/effects/periodic.hpp"

namespace qerr {

namespace {

int place_in_stage(const EffectKind& kind) { return kind.first_in_stage ? 0 : is_periodic(kind) ? 1 : 2; }

}  // namespace

bool acts_before(const EffectKind& a, const EffectKind& b) {
  if (a.stage != b.stage) return a.stage < b.stage;
  if (a.stage == Stage::decoder) return std::less<>()(&a, &b);  // of one list
  return place_in_stage(a) < place_in_stage(b);
}

void ActionPath::add(const EffectKind& kind, Action action) {
  const auto next = std::ranges::upper_bound(steps_, kind, acts_before,
                                             [](const Step& s) -> const EffectKind& { return *s.kind; });
  if (is_periodic(kind) && next != steps_.begin() && is_periodic(*std::prev(next)->kind) &&
      std::prev(next)->kind->stage == kind.stage)
    std::prev(next)->actions.push_back(std::move(action));
  else
    steps_.insert(next, {&kind, {std::move(action)}});
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
