#include "diagnose/surrogates/residual_filter.hpp"

#include <algorithm>

namespace qerr {

ResidualFilter::ResidualFilter(const Filter& filter, std::size_t width, std::size_t most_rows,
                               const ResidualKernels& kernels)
    : kernels_(&kernels), width_(width), taps_(filter.taps) {
  const auto plain = [](auto c) { return static_cast<double>(c); };
  for (const Section& s : filter.sections) {
    const double a0 = plain(s.a[0]), a01 = a0 + plain(s.a[1]), inverse = 1 / (a01 + plain(s.a[2]));
    sections_.push_back({plain(s.a[2]) != 0, inverse, a0 * inverse, a01 * inverse, plain(s.b[0]),
                         plain(s.b[1]), plain(s.b[2])});
  }
  const auto gain = static_cast<double>(filter.gain);
  if (!sections_.empty()) {
    sections_.front().in *= gain;
  } else {
    if (taps_.empty()) taps_ = {1};
    for (double& tap : taps_) tap *= gain;
  }
  state_ = AlignedNumbers(2 * sections_.size() * width);
  if (!taps_.empty()) past_ = AlignedNumbers((taps_.size() - 1 + most_rows) * width);
}

void ResidualFilter::start() {
  for (const AlignedNumbers* a : {&state_, &past_}) std::fill_n(a->data(), a->size(), 0.0);
}

void ResidualFilter::operator()(const double* in, std::size_t rows, double* out) {
  double* state = state_.data();
  for (const ResidualSection& s : sections_) {
    kernels_->section(s, in, rows, width_, state, out);
    in = out;
    state += 2 * width_;
  }
  if (taps_.empty()) return;
  const std::size_t before = (taps_.size() - 1) * width_;
  std::copy_n(in, rows * width_, past_.data() + before);
  kernels_->taps(taps_.data(), taps_.size(), past_.data() + before, rows, width_, out);
  std::copy_n(past_.data() + rows * width_, before, past_.data());
}

}  // namespace qerr
