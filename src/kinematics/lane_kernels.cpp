#include "kinematics/kernels.hpp"
#include "kinematics/walk.hpp"
#include "lanes/batch.hpp"
#include "lanes/compiled_set.hpp"
#include "lanes/lane_words.hpp"

namespace qerr::lanes {
namespace {

/// Columns of one configuration per lane into [6 k + row][batch_size].
template <class L>
struct PutColumns {
  double* to;
  [[gnu::always_inline]] void upright(const L& x, const L& y, double w) const {
    column(0, {x, y, L{}}, {L{}, L{}, broadcast<L>(w)});
  }
  [[gnu::always_inline]] void column(std::size_t k, const L (&linear)[3], const L (&angular)[3]) const {
#pragma GCC unroll 3
    for (std::size_t row = 0; row < 3; ++row) {
      store(to + (6 * k + row) * batch_size, linear[row]);
      store(to + (6 * k + 3 + row) * batch_size, angular[row]);
    }
  }
};

template <class L>
void jacobians(const FoldedPath& chain, const double* signs, const double* q, double* to, double* room) {
  auto* const moved = reinterpret_cast<SineCosine<L>*>(room);
  auto* const joints = reinterpret_cast<JointRoom<L>*>(moved + chain.count);
  begin_columns(chain, signs, joints);
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
    const PutColumns<L> put{to + i};
    columns<L>(chain, signs, q + i, batch_size, moved, joints, PassBy{}, put);
  }
}

template <class L>
[[gnu::always_inline]] inline Words<L> load_words(const std::uint64_t* from) {
  Words<L> words;
  __builtin_memcpy(&words, from, sizeof words);
  return words;
}

/// Whole numbers below 2^53 as doubles.
template <class L>
[[gnu::always_inline]] inline L number(const Words<L>& whole) {
#if defined(__AVX512DQ__)
  return __builtin_convertvector(__builtin_bit_cast(Bits<L>, whole), L);
#else
  // Both halves become numbers by the exponents put before them: 2^84 + high 2^32 and 2^52 + low.
  const L high = __builtin_bit_cast(L, (whole >> 32) | 0x4530000000000000u);
  const L low = __builtin_bit_cast(L, (whole & 0xFFFFFFFFu) | 0x4330000000000000u);
  return (high - 0x1.00000001p84) + low;
#endif
}

/// A joint's range in registers: what is stored might be the range itself, for all the compiler knows.
template <class L>
struct Range {
  L lower, scale, upper;

  [[gnu::always_inline]] Range(const SampledRanges& r, std::size_t joint)
      : lower(broadcast<L>(r.lower[joint])),
        scale(broadcast<L>(0x1p-53 * r.width[joint])),
        upper(broadcast<L>(r.upper[joint])) {}

  /// lower + fraction (upper - lower), inside the range; the fraction in units of 2^-53.
  ///
  /// Rounded as `draw` rounds it: exactly up to the product, which is rounded before the sum; that is not
  /// below `lower`.
  [[gnu::always_inline]] L at(const Words<L>& fraction) const {
    return min(rounded(number<L>(fraction) * scale) + lower, upper);
  }
};

template <class L>
void sobol(const SampledRanges& r, const std::uint64_t* start, const std::uint64_t* patterns, double* to) {
  for (std::size_t joint = 0; joint < r.joints; ++joint) {
    const Range<L> range(r, joint);
    const Words<L> first = Words<L>{} + start[joint];
    for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
      const std::size_t at = joint * batch_size + i;
      store(to + at, range.at(load_words<L>(patterns + at) ^ first));
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
            range.at(mixed<Words<L>>((index + 1) * 0x9E3779B97F4A7C15u + key) >> 11));
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
  static constexpr KinematicKernels kernels{lane_count<L>, room_per_joint<L>, jacobians<L>, sobol<L>,
                                            random<L>};
  return kernels;
}

}  // namespace qerr
