#include "diagnose/terms/scan_kernels.hpp"
#include "lanes/compiled_set.hpp"
#include "lanes/lanes.hpp"

// Power of a score at many rates.

namespace qerr::lanes {
namespace {

/// A complex number in each lane.
template <class L>
struct Phasor {
  L real, imaginary;
};

template <class L>
[[gnu::always_inline]] inline Phasor<L> operator*(const Phasor<L>& a, const Phasor<L>& b) {
  return {fma(a.real, b.real, -(a.imaginary * b.imaginary)), fma(a.real, b.imaginary, a.imaginary * b.real)};
}

template <class L>
[[gnu::always_inline]] inline Phasor<L> operator+(const Phasor<L>& a, const Phasor<L>& b) {
  return {a.real + b.real, a.imaginary + b.imaginary};
}

/// |the sum of all lanes|^2.
template <class L>
[[gnu::always_inline]] inline double power_of(const Phasor<L>& sum) {
  double real = 0, imaginary = 0;
  for (std::size_t i = 0; i < lane_count<L>; ++i) real += sum.real[i], imaginary += sum.imaginary[i];
  return real * real + imaginary * imaginary;
}

/// Adds the rows to the sums of `count` rates. Rows are processed in groups of independent vectors, whose
/// recursions overlap in the pipeline.
template <class L>
void step_rates(std::size_t rows, std::size_t count, const Phasor<L>* steps, Phasor<L>* phasors,
                Phasor<L>* sums) {
  constexpr std::size_t group = lane_count<L> == 8 ? 4 : 2;
  static_assert(scanned_together % (group * lane_count<L>) == 0);
  for (std::size_t v = 0; v < rows / lane_count<L>; v += group) {
    Phasor<L> step[group], phasor[group];
#pragma GCC unroll 4
    for (std::size_t g = 0; g < group; ++g) step[g] = steps[v + g], phasor[g] = phasors[v + g];
    for (std::size_t i = 0; i < count; ++i) {
      Phasor<L> sum = phasor[0] + phasor[1];
      if constexpr (group == 4) sum = sum + (phasor[2] + phasor[3]);
      sums[i] = sums[i] + sum;
#pragma GCC unroll 4
      for (std::size_t g = 0; g < group; ++g) phasor[g] = phasor[g] * step[g];
    }
#pragma GCC unroll 4
    for (std::size_t g = 0; g < group; ++g) phasors[v + g] = phasor[g];
  }
}

template <class L>
void powers(const double* score, const double* angle, std::size_t rows, double first, std::size_t count,
            double* scratch, double* powers) {
  constexpr auto lanes = lane_count<L>;
  auto* const steps = reinterpret_cast<Phasor<L>*>(scratch);
  Phasor<L>*const phasors = steps + rows / lanes, *const sums = phasors + rows / lanes;
  for (std::size_t v = 0; v < rows / lanes; ++v) {
    const L each = load<L>(angle + v * lanes), weight = load<L>(score + v * lanes);
    const SineCosine<L> step = sincos(each), start = sincos<L>(first * each);
    steps[v] = {step.cosine, step.sine};
    phasors[v] = {weight * start.cosine, weight * start.sine};
  }
  for (std::size_t begin = 0; begin < count; begin += scanned_at_once) {
    const std::size_t some = count - begin < scanned_at_once ? count - begin : scanned_at_once;
    for (std::size_t i = 0; i < some; ++i) sums[i] = Phasor<L>{};
    step_rates<L>(rows, some, steps, phasors, sums);
    for (std::size_t i = 0; i < some; ++i) powers[begin + i] = power_of(sums[i]);
  }
}

template <class L>
double power(const double* score, const double* argument, std::size_t rows, double rate) {
  Phasor<L> sum{};
  for (std::size_t k = 0; k < rows; k += lane_count<L>) {
    const SineCosine<L> wave = sincos<L>(rate * load<L>(argument + k));
    const L weight = load<L>(score + k);
    sum = {fma(weight, wave.cosine, sum.real), fma(weight, wave.sine, sum.imaginary)};
  }
  return power_of(sum);
}

}  // namespace
}  // namespace qerr::lanes

namespace qerr {

template <>
const ScanKernels& compiled_kernels<ScanKernels, lanes::compiled_set>() {
  using namespace lanes;
  using L = CompiledLanes;
  static constexpr ScanKernels kernels{powers<L>, power<L>};
  return kernels;
}

}  // namespace qerr
