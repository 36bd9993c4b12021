#include "simulate/estimators/estimator.hpp"

#include <cmath>
#include <stdexcept>

#include "core/search.hpp"

namespace qerr {

ActionPath disc_actions(const std::vector<Effect>& effects, const Encoder& encoder,
                        const std::string& joint) {
  ActionPath actions;
  for (const Effect& e : effects)
    if (const EffectKind& kind = effect_kind(e.type);
        e.joint == joint && (kind.stage == Stage::disc || kind.stage == Stage::line) && kind.action)
      actions.add(kind, kind.action(e, encoder, 0));
  return actions;
}

EdgeFinder::EdgeFinder(const Encoder& encoder, ActionPath disc, EncoderPath path, double start)
    : resolution_(encoder.resolution),
      below_(below_reading(encoder)),
      disc_(std::move(disc)),
      path_(std::move(path)),
      now_(start),
      velocity_(path_.velocity(start)),
      tolerance_(1e-9 * path_.step) {}

/// The position that the disc shows, in counts, so that the count is its floor.
double EdgeFinder::shown(double time) const {
  const double joint = path_.position(time);
  return disc_(joint, {.time = time, .joint = joint}) / resolution_ + below_;
}

const std::vector<Edge>& EdgeFinder::until(double time) {
  edges_.clear();
  while (now_ < time) {
    const double from = now_, to = std::min(time, from + path_.step);
    const double next = path_.velocity(to);
    if (velocity_ * next < 0) {
      const double before =
          bisect({from, to}, 60, [&](double t) { return path_.velocity(t) * velocity_ > 0; }).holds;
      cross(from, before);
      cross(before, to);
    } else {
      cross(from, to);
    }
    now_ = to;
    velocity_ = next;
  }
  return edges_;
}

/// Adds the edges between two instants, between which the position is monotone.
void EdgeFinder::cross(double from, double to) {
  const double first = std::floor(shown(from)), last = std::floor(shown(to));
  const int direction = last > first ? 1 : -1;
  for (double count = first; count != last; count += direction) {
    const double threshold = direction > 0 ? count + 1 : count;
    from = root(from, to, threshold);
    edges_.push_back({from, direction});
  }
}

/// The instant at which the position crosses a threshold that lies between those at both ends.
double EdgeFinder::root(double from, double to, double threshold) const {
  double below = shown(from) - threshold, above = shown(to) - threshold;
  constexpr int most = 100;  // the bracket at least halves in every third step
  for (int i = 0; i < most && to - from > tolerance_; ++i) {
    double middle =
        i % 3 == 2 || below == above ? 0.5 * (from + to) : to - above * (to - from) / (above - below);
    if (!(middle > from && middle < to)) middle = 0.5 * (from + to);
    const double value = shown(middle) - threshold;
    if (value == 0) return middle;
    if ((value > 0) == (above > 0)) {
      to = middle, above = value;
      below *= 0.5;
    } else {
      from = middle, below = value;
      above *= 0.5;
    }
  }
  return 0.5 * (from + to);
}

const std::vector<EstimatorKind>& estimator_kinds() {
  static const std::vector<EstimatorKind> list{
#define QERR_ESTIMATOR(name) name##_estimator(),
#include "simulate/estimators/list.inc"
#undef QERR_ESTIMATOR
  };
  return list;
}

const EstimatorKind& estimator_kind(std::string_view name) {
  for (const EstimatorKind& kind : estimator_kinds())
    if (kind.name == name) return kind;
  throw std::out_of_range("no estimator kind " + std::string(name));
}

Parameter clock_row() {
  return key::number("clock", "frequency of the timer that stamps the edges, down to a tick",
                     dimension::frequency)
      .within(1e-3, 1e15)
      .needed();
}

Parameter timeout_row() {
  return key::number("timeout", "without an edge for so long the velocity is 0; default: never",
                     dimension::time)
      .above(0);
}

}  // namespace qerr
