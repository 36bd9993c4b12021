#include "filter/run/cascade.hpp"

namespace qerr {
namespace {

template <class Scalar>
Scalar to(DoubleDouble x) {
  return static_cast<Scalar>(x);
}

}  // namespace

template <class Scalar>
BasicCascade<Scalar>::BasicCascade(const Filter& filter)
    : taps_(filter.taps), past_(filter.taps.size()), gain_(to<Scalar>(filter.gain)) {
  for (const Section& s : filter.sections) {
    Stage stage;
    stage.second = s.a[2] != 0;
    stage.b0 = to<Scalar>(s.b[0]);
    stage.b1 = to<Scalar>(s.b[1]);
    stage.b2 = to<Scalar>(s.b[2]);
    stage.a0 = to<Scalar>(s.a[0]);
    stage.a01 = to<Scalar>(s.a[0] + s.a[1]);
    stage.inverse = to<Scalar>(DoubleDouble(1) / (s.a[0] + s.a[1] + s.a[2]));
    stages_.push_back(stage);
  }
}

template <class Scalar>
Scalar BasicCascade<Scalar>::Stage::step(Scalar x) {
  if (!second) {
    const Scalar high = (x - a0 * s1) * inverse;
    const Scalar low = high + s1;
    s1 = low + high;
    return b0 * low + b1 * high;
  }
  const Scalar high = (x - a01 * s1 - a0 * s2) * inverse;
  const Scalar band = high + s1;
  const Scalar low = band + s2;
  s1 = band + high;
  s2 = low + band;
  return b0 * low + b1 * band + b2 * high;
}

template <class Scalar>
Scalar BasicCascade<Scalar>::step(Scalar input) {
  Scalar x = input * gain_;
  for (Stage& stage : stages_) x = stage.step(x);
  if (taps_.empty()) return x;
  past_[next_] = x;
  Scalar y{};
  std::size_t at = next_;
  for (const double tap : taps_) {
    y += Scalar(tap) * past_[at];
    at = (at == 0 ? past_.size() : at) - 1;
  }
  next_ = (next_ + 1) % past_.size();
  return y;
}

template class BasicCascade<double>;
template class BasicCascade<DoubleDouble>;

}  // namespace qerr
