#include "simulate/channel_filter.hpp"

#include <algorithm>
#include <utility>

#include "lanes/batch.hpp"

namespace qerr {

namespace {

/// Divides the section by the only one of b0, b1, b2 that is not 0, if there is one. @returns it, or 1
double take_factor(SectionPlan& s) {
  using Output = SectionPlan::Output;
  const auto only = [&](double& b, Output output) {
    s.output = output;
    return std::exchange(b, 1);
  };
  if (s.b1 == 0 && s.b2 == 0) return only(s.b0, Output::low);
  if (s.b0 == 0 && s.b2 == 0) return only(s.b1, Output::band);
  if (s.b0 == 0 && s.b1 == 0) return only(s.b2, Output::high);
  s.output = Output::all;
  return 1;
}

void multiply(SectionPlan& s, double gain) {
  using Output = SectionPlan::Output;
  if (s.output == Output::low) s.output = Output::scaled_low;
  if (s.output == Output::band) s.output = Output::scaled_band;
  if (s.output == Output::high) s.output = Output::scaled_high;
  for (double* b : {&s.b0, &s.b1, &s.b2}) *b *= gain;
}

}  // namespace

ChannelFilter::ChannelFilter(const Filter& filter, std::size_t width, InstructionSet set)
    : taps_(filter.taps), width_(width), kernels_(select_kernels<SimulationKernels>(set)) {
  const auto plain = [](auto c) { return static_cast<double>(c); };
  auto gain = static_cast<double>(filter.gain);
  for (const Section& s : filter.sections) {
    const double a0 = plain(s.a[0]), a01 = a0 + plain(s.a[1]), inverse = 1 / (a01 + plain(s.a[2]));
    sections_.push_back({plain(s.a[2]) != 0, SectionPlan::Output::all, a0 * inverse, a01 * inverse,
                         plain(s.b[0]), plain(s.b[1]), plain(s.b[2])});
    // Its highest derivative is times a01 + a2. Such factors of every section are put into the last one.
    gain *= inverse * take_factor(sections_.back());
  }
  if (!sections_.empty()) {
    multiply(sections_.back(), gain);
  } else if (taps_.empty()) {
    taps_ = {gain};
  } else {
    for (double& tap : taps_) tap *= gain;
  }
  state_ = AlignedNumbers(2 * sections_.size() * width);
  if (!taps_.empty()) past_ = AlignedNumbers((taps_.size() - 1 + batch_size) * width);
}

void ChannelFilter::settle(const double* row) {
  for (std::size_t c = 0; c < width_; ++c) {
    double x = row[c];
    double* state = state_.data() + c;
    for (const SectionPlan& s : sections_) {
      // Nothing changes: the highest derivative is 0, and k0 times the low-pass state is the input.
      const double low = x / s.k0;
      state[s.second ? width_ : 0] = low;
      x = s.b0 * low;
      state += 2 * width_;
    }
    for (std::size_t k = 0; k + 1 < taps_.size(); ++k) past_[k * width_ + c] = x;
  }
}

void ChannelFilter::operator()(const double* in, std::size_t stride, std::size_t rows, double* out) {
  if (!taps_.empty()) return through_taps(in, stride, rows, out);
  double* state = state_.data();
  for (const SectionPlan& s : sections_) {
    kernels_.section(s, in, stride, rows, width_, state, out);
    in = out;
    stride = width_;
    state += 2 * width_;
  }
}

void ChannelFilter::through_taps(const double* in, std::size_t stride, std::size_t rows, double* out) {
  const std::size_t before = (taps_.size() - 1) * width_;
  for (std::size_t row = 0; row < rows; ++row)
    std::copy_n(in + row * stride, width_, past_.data() + before + row * width_);
  kernels_.taps(taps_.data(), taps_.size(), past_.data() + before, rows, width_, out);
  std::copy_n(past_.data() + rows * width_, before, past_.data());
}

}  // namespace qerr
