#include "filter/run/cascade.hpp"

namespace qerr {

template <class Number>
Cascade<Number>::Cascade(const Filter& filter)
    : plan_(filter_plan<Number>(filter)), states_(plan_.sections.size()), past_(plan_.taps.size()) {}

template <class Number>
Number Cascade<Number>::step(Number x) {
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const NormalizedSection<Number>& s = plan_.sections[i];
    x = s.second ? output<true>(s.b0, s.b1, s.b2, advance<true>(s.k0, s.k1, x, states_[i]))
                 : output<false>(s.b0, s.b1, s.b2, advance<false>(s.k0, s.k1, x, states_[i]));
  }
  if (past_.empty()) return x;
  newest_ = (newest_ == 0 ? past_.size() : newest_) - 1;
  past_[newest_] = x;
  Number y{};
  std::size_t i = newest_;
  for (const Number& tap : plan_.taps) {
    y += tap * past_[i];
    i = i + 1 == past_.size() ? 0 : i + 1;
  }
  return y;
}

template class Cascade<double>;
template class Cascade<DoubleDouble>;

}  // namespace qerr
