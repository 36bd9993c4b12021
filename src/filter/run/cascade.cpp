#include "filter/run/cascade.hpp"

#include <algorithm>

#include "lanes/select_kernels.hpp"

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

RowFilter::RowFilter(const Filter& filter, std::size_t width, std::size_t most_rows, InstructionSet set)
    : plan_(filter_plan<double>(filter)),
      width_(width),
      kernels_(&select_kernels<FilterKernels>(set)),
      state_(2 * plan_.sections.size() * width) {
  if (!plan_.taps.empty()) past_ = AlignedNumbers((plan_.taps.size() - 1 + most_rows) * width);
}

void RowFilter::reset() {
  for (const AlignedNumbers* numbers : {&state_, &past_}) std::fill_n(numbers->data(), numbers->size(), 0.0);
}

void RowFilter::settle(const double* row) {
  for (std::size_t c = 0; c < width_; ++c) {
    double x = row[c];
    std::size_t at = c;
    for (const NormalizedSection<double>& s : plan_.sections) {
      // In steady state high = 0, s1 = band = 0 for second order, and k0 low = x.
      const double low = x / s.k0;
      state_[at] = s.second ? 0 : low;
      state_[at + width_] = s.second ? low : 0;
      x = s.b0 * low;
      at += 2 * width_;
    }
    for (std::size_t k = 0; k + 1 < plan_.taps.size(); ++k) past_[k * width_ + c] = x;
  }
}

void RowFilter::operator()(const double* in, std::size_t stride, std::size_t rows, double* out) {
  if (!plan_.taps.empty()) return run_taps(in, stride, rows, out);
  double* state = state_.data();
  for (const NormalizedSection<double>& s : plan_.sections) {
    kernels_->section(s, in, stride, rows, width_, state, out);
    in = out;
    stride = width_;
    state += 2 * width_;
  }
}

void RowFilter::run_taps(const double* in, std::size_t stride, std::size_t rows, double* out) {
  const std::size_t before = (plan_.taps.size() - 1) * width_;
  for (std::size_t row = 0; row < rows; ++row)
    std::copy_n(in + row * stride, width_, past_.data() + before + row * width_);
  kernels_->taps(plan_.taps.data(), plan_.taps.size(), past_.data() + before, rows, width_, out);
  std::copy_n(past_.data() + rows * width_, before, past_.data());
}

}  // namespace qerr
