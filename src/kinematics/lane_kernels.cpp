#include "kinematics/kernels.hpp"
#include "kinematics/walk.hpp"
#include "lanes/batch.hpp"
#include "lanes/lanes.hpp"
#include "lanes/select_kernels.hpp"

namespace qerr::lanes {
namespace {

/// Stores the columns of one configuration per lane at [6 k + row][batch_size].
template <class L>
struct WriteColumns {
  double* to;
  [[gnu::always_inline]] void column(std::size_t k, const L (&linear)[3], const L (&angular)[3]) const {
#pragma GCC unroll 3
    for (std::size_t row = 0; row < 3; ++row) {
      store(to + (6 * k + row) * batch_size, linear[row]);
      store(to + (6 * k + 3 + row) * batch_size, angular[row]);
    }
  }
};

template <class L>
void jacobians(const FoldedPath& chain, const double* signs, const double* q, double* to, double* scratch) {
  auto* const motions = reinterpret_cast<SineCosine<L>*>(scratch);
  auto* const joints = reinterpret_cast<JointScratch<L>*>(motions + chain.count);
  prepare_first_joint(chain, signs, joints);
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
    const WriteColumns<L> write{to + i};
    columns<L>(chain, signs, q + i, batch_size, motions, joints, Ignore{}, write);
  }
}

template <class L>
[[gnu::always_inline]] inline Words<L> load_words(const std::uint64_t* from) {
  Words<L> words;
  __builtin_memcpy(&words, from, sizeof words);
  return words;
}

/// Integers below 2^53 as doubles.
template <class L>
[[gnu::always_inline]] inline L number(const Words<L>& integers) {
#if defined(__AVX512DQ__)
  return __builtin_convertvector(__builtin_bit_cast(Bits<L>, integers), L);
#else
  // Exponents put before both halves give 2^84 + high 2^32 and 2^52 + low.
  const L high = __builtin_bit_cast(L, (integers >> 32) | 0x4530000000000000u);
  const L low = __builtin_bit_cast(L, (integers & 0xFFFFFFFFu) | 0x4330000000000000u);
  return (high - 0x1.00000001p84) + low;
#endif
}

/// A joint's range in registers: the compiler must assume that stores alias the range in memory.
template <class L>
struct Range {
  L lower, scale, upper;

  [[gnu::always_inline]] Range(const SampledRanges& r, std::size_t joint)
      : lower(broadcast<L>(r.lower[joint])),
        scale(broadcast<L>(0x1p-53 * r.width[joint])),
        upper(broadcast<L>(r.upper[joint])) {}

  /// lower + fraction (upper - lower), inside the range; the fraction in units of 2^-53.
  ///
  /// Rounded like `draw`: the product is rounded before the sum (not fused), which therefore is >= `lower`.
  [[gnu::always_inline]] L value(const Words<L>& fraction) const {
    return min(rounded(number<L>(fraction) * scale) + lower, upper);
  }
};

template <class L>
void sobol(const SampledRanges& r, const std::uint64_t* start, const std::uint64_t* patterns, double* to) {
  for (std::size_t joint = 0; joint < r.joints; ++joint) {
    const Range<L> range(r, joint);
    const Words<L> first = Words<L>{} + start[joint];
    for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
      const std::size_t index = joint * batch_size + i;
      store(to + index, range.value(load_words<L>(patterns + index) ^ first));
    }
  }
}

template <class L>
void random(const SampledRanges& r, const std::uint64_t* keys, std::uint64_t first, double* to) {
  Words<L> lane;
  for (std::size_t i = 0; i < lane_count<L>; ++i) lane[i] = i;
  for (std::size_t joint = 0; joint < r.joints; ++joint) {
    const Range<L> range(r, joint);
    const std::uint64_t key = keys[joint];
    for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
      const Words<L> index = lane + (first + i);
      store(to + joint * batch_size + i,
            range.value(mixed<Words<L>>((index + 1) * 0x9E3779B97F4A7C15u + key) >> 11));
    }
  }
}

}  // namespace
}  // namespace qerr::lanes

namespace qerr {

template <>
const KinematicKernels& compiled_kernels<KinematicKernels, lanes::compiled_set>() {
  using namespace lanes;
  using L = CompiledLanes;
  static constexpr KinematicKernels kernels{lane_count<L>, scratch_per_joint<L>, jacobians<L>, sobol<L>,
                                            random<L>};
  return kernels;
}

}  // namespace qerr
