#include <utility>

#include "lanes/batch.hpp"
#include "lanes/lanes.hpp"
#include "lanes/select_kernels.hpp"
#include "simulate/lane_columns.hpp"

namespace qerr::lanes {

// Linear errors J e: contributions of the encoders to a coordinate, their sums, and the sums of their
// squares.

namespace {

/// Stores a channel at these instants for the rows.
template <class L>
[[gnu::always_inline]] inline void set_channel(const ErrorScratch<L>& scratch, std::size_t channel,
                                               const L (&value)[depth]) {
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) scratch.channels[depth * channel + i] = value[i];
}

/// Linear error of one coordinate at these instants: sums over the encoders.
template <class L>
struct Linear {
  L error[depth], sizes[depth], squares[depth];
};

/// @param bounded  no lane is at the gimbal lock
template <class L>
[[gnu::always_inline]] inline Linear<L> linear_errors(const PathErrorPlan& p, std::size_t c, bool bounded,
                                                      const ErrorScratch<L>& scratch) {
  Linear<L> all{};
  for (std::size_t e = 0; e < p.encoders; ++e) {
    const L* const column = column_of(scratch, e) + p.rows[c];
    const L* const residual_counts = scratch.residual_counts + depth * e;
    L part[depth];
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) {
      L weighted = column[i * next_vector(scratch)];
      if (!bounded) weighted = scratch.unbounded[i] ? broadcast<L>(__builtin_inf()) : weighted;
      part[i] = weighted * residual_counts[i];
      all.error[i] += part[i];
      all.sizes[i] += abs(weighted);
      all.squares[i] = fma(weighted, weighted, all.squares[i]);
    }
    set_channel(scratch, p.coordinates * (2 + e) + c, part);
  }
  return all;
}

/// One step of transposing a square of lanes: exchanges blocks of rows `a` and `b`, which are `distance`
/// apart.
template <std::size_t distance, class L, std::size_t... i>
[[gnu::always_inline]] inline void cross_over(L& a, L& b, std::index_sequence<i...>) {
  constexpr auto n = sizeof...(i);
  const L first = __builtin_shufflevector(a, b, (i & distance ? n + i - distance : i)...);
  b = __builtin_shufflevector(a, b, (i & distance ? n + i : i + distance)...);
  a = first;
}

template <std::size_t distance, class L>
[[gnu::always_inline]] inline void cross_rows(L* rows) {
  constexpr auto n = lane_count<L>;
#pragma GCC unroll 8
  for (std::size_t row = 0; row < n; ++row)
    if (!(row & distance))
      cross_over<distance>(rows[row], rows[row + distance], std::make_index_sequence<n>{});
  if constexpr (distance > 1) cross_rows<distance / 2>(rows);
}

/// Transposes channels of one vector of instants, `stride` numbers apart, into rows of `width` channels.
template <class L>
[[gnu::always_inline]] inline void into_rows(const double* channels, std::size_t stride, std::size_t width,
                                             double* rows) {
  constexpr auto n = lane_count<L>;
  for (std::size_t c = 0; c < width; c += n) {
    L square[n];
#pragma GCC unroll 8
    for (std::size_t i = 0; i < n; ++i) square[i] = load<L>(channels + (c + i) * stride);
    cross_rows<n / 2>(square);
#pragma GCC unroll 8
    for (std::size_t i = 0; i < n; ++i) store(rows + i * width + c, square[i]);
  }
}

/// The mean error of a coordinate at the i-th vector of instants; adds the contributions of the mean and of
/// the sources to `worst`.
template <class L>
[[gnu::always_inline]] inline L mean_error(const PathErrorPlan& p, std::size_t c, std::size_t i,
                                           const ErrorScratch<L>& scratch, L& worst) {
  L mean{};
  if (!p.biased && p.sources == 0) return mean;
  const std::size_t row = static_cast<std::size_t>(p.rows[c]) + i * next_vector(scratch);
  for (std::size_t e = 0; e < p.encoders + p.sources; ++e) {
    const L along = column_of(scratch, e)[row];
    mean = fma(p.columns[e].mean, along, mean);
    if (e >= p.encoders) worst = fma(p.columns[e].half_width, abs(along), worst);
  }
  worst += abs(mean);
  return mean;
}

/// Updates the largest bounds of a coordinate with those at these instants.
template <class L>
[[gnu::noinline]] void raise_bounds(const PathErrorPlan& p, const PathErrorBatch& b, std::size_t c,
                                    const ErrorScratch<L>& scratch) {
  L rigorous = load<L>(b.rigorous + c * lane_count<L>), deviation = load<L>(b.deviation + c * lane_count<L>);
  for (std::size_t i = 0; i < depth; ++i) {
    L worst{};
    for (std::size_t e = 0; e < p.encoders; ++e)
      worst +=
          0.5 * abs(column_of(scratch, e)[static_cast<std::size_t>(p.rows[c]) + i * next_vector(scratch)]);
    const L mean = mean_error(p, c, i, scratch, worst);
    L bound = min(worst + p.rotation, broadcast<L>(p.rotation_angle));
    if (p.rows[c] < 3)
      bound = worst + p.remainder + weighted_column_norms(p.chain, p.per_column, scratch.joints(i));
    rigorous = max(rigorous, bound);
    deviation = max(deviation, bound - abs(mean) + abs(mean - p.center_mean[c]));
  }
  store(b.rigorous + c * lane_count<L>, rigorous);
  store(b.deviation + c * lane_count<L>, deviation);
}

/// Mean and bounds of a coordinate along the path.
template <class L>
[[gnu::always_inline]] inline void bound_errors(const PathErrorPlan& p, const PathErrorBatch& b,
                                                std::size_t c, const L (&sizes)[depth],
                                                const ErrorScratch<L>& scratch) {
  L mean[depth], largest{}, farthest{};
#pragma GCC unroll 4
  for (std::size_t i = 0; i < depth; ++i) {
    L worst = 0.5 * sizes[i];
    mean[i] = mean_error(p, c, i, scratch, worst);
    largest = max(largest, worst);
    farthest = max(farthest, worst - abs(mean[i]) + abs(mean[i] - p.center_mean[c]));
  }
  if (p.biased) set_channel(scratch, p.coordinates * (2 + p.encoders) + c, mean);
  if (p.rows[c] >= 6) return;
  const double most = p.rows[c] < 3 ? p.largest_remainder : p.rotation;
  // New maxima are rare; skip the square roots of the remainder otherwise.
  if (any<L>((largest + most > load<L>(b.rigorous + c * lane_count<L>)) |
             (farthest + most > load<L>(b.deviation + c * lane_count<L>))))
    raise_bounds(p, b, c, scratch);
}

template <class L>
[[gnu::always_inline]] inline bool any_unbounded(const PathErrorPlan& p, const ErrorScratch<L>& scratch) {
  return p.angles && any<L>((scratch.unbounded[0] | scratch.unbounded[1]) |
                            (scratch.unbounded[2] | scratch.unbounded[3]));
}

/// Computes all channels of all coordinates at `depth` vectors of instants from `at`.
template <class L>
[[gnu::noinline]] void set_coordinates(const PathErrorPlan& p, const PathErrorBatch& b, std::size_t at,
                                       const ErrorScratch<L>& scratch) {
  const bool unbounded = any_unbounded(p, scratch);
  for (std::size_t c = 0; c < p.coordinates; ++c) {
    const auto row = static_cast<std::size_t>(p.rows[c]);
    L exact[depth];
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i) exact[i] = scratch.pose[depth * row + i];
    set_channel(scratch, c, exact);
    const Linear<L> linear = linear_errors(p, c, !unbounded || row < 6, scratch);
    set_channel(scratch, p.coordinates + c, linear.error);
#pragma GCC unroll 4
    for (std::size_t i = 0; i < depth; ++i)
      store(b.variance + c * batch_size + at + i * lane_count<L>, linear.squares[i]);
    bound_errors(p, b, c, linear.sizes, scratch);
  }
}

/// Errors of a batch of instants: exact pose error, and linear errors J e of the encoders
/// (operational_error).
template <class L>
void errors(const PathErrorPlan& p, const PathErrorBatch& b) {
  constexpr auto lanes = lane_count<L>;
  const ErrorScratch<L> scratch = scratch_of<L>(p, b.scratch);
  begin_errors(p, scratch);
  for (std::size_t at = 0; at < batch_size; at += depth * lanes) {
    for (std::size_t i = 0; i < depth; ++i) move_tip(p, b, at + i * lanes, i, scratch);
    set_coordinates(p, b, at, scratch);
    for (std::size_t i = 0; i < depth; ++i)
      into_rows<L>(reinterpret_cast<const double*>(scratch.channels + i), depth * lanes, p.width,
                   b.rows + (at + i * lanes) * p.width);
  }
}

}  // namespace

namespace {

/// x / divisor, correctly rounded, so that ties of a quantizer are preserved: the residual of the first
/// quotient is exact and corrects it.
template <class L>
[[gnu::always_inline]] inline L over(const L& x, double divisor, double inverse) {
#if defined(__FMA__) || defined(__aarch64__)
  const L quotient = x * inverse;
  return fma(fma(-quotient, divisor, x), inverse, quotient);
#else
  static_cast<void>(inverse);
  return x / divisor;
#endif
}

template <class L>
void times(double first, std::size_t count, double rate, double* to) {
  const double inverse = 1 / rate, last = static_cast<double>(static_cast<int>(count) - 1);
  L i;
  for (std::size_t k = 0; k < lane_count<L>; ++k) i[k] = static_cast<double>(static_cast<int>(k));
  for (std::size_t k = 0; k < batch_size; k += lane_count<L>) {
    store(to + k, over<L>(first + min(i, broadcast<L>(last)), rate, inverse));
    i += static_cast<double>(static_cast<int>(lane_count<L>));
  }
}

/// Sine only, absolute error 3e-16: (-1)^n sin(angle - n pi) with the nearest multiple n of pi. One
/// polynomial on
/// +-pi/2 (degree 19, error 4e-17) takes fewer operations than the two of `sincos`; large angles as there.
template <class L>
[[gnu::always_inline]] inline L sine(const L& angle) {
  constexpr double one_over_pi = 0x1.45f306dc9c883p-2, shift = 0x1.8p52;
  const L shifted = fma(angle, one_over_pi, broadcast<L>(shift));
  const L n = shifted - shift;
#if defined(__FMA__) || defined(__aarch64__)
  const L r = fma(n, -0x1.1a62633145c07p-53, fma(n, -0x1.921fb54442d18p+1, angle));
#else
  const L r = ((angle - n * 0x1.921fb544p+1) - n * 0x1.0b4611a6p-33) - n * 0x1.3198a2e037073p-68;
#endif
  const L s = r * r;
  const L sum = polynomial(s, -0x1.5555555555555p-3, 0x1.1111111111107p-7, -0x1.a01a01a018aaap-13,
                           0x1.71de3a54564dfp-19, -0x1.ae6455a1c0795p-26, 0x1.612401540ed0fp-33,
                           -0x1.ae51366b753a9p-41, 0x1.89a43bea5b135p-49);
  const L of_r = fma(s * r, sum, r);
  return __builtin_bit_cast(L,
                            __builtin_bit_cast(Bits<L>, of_r) ^ (__builtin_bit_cast(Bits<L>, shifted) << 63));
}

/// Groups of independent vectors of instants hide the latency of the sines.
template <class L>
void positions(const SinusoidPath& path, const double* time, double* to) {
  constexpr std::size_t lanes = lane_count<L>, group = 4;
  for (std::size_t i = 0; i < batch_size; i += group * lanes) {
    L t[group], position[group];
#pragma GCC unroll 4
    for (std::size_t g = 0; g < group; ++g) {
      t[g] = load<L>(time + i + g * lanes);
      position[g] = fma(path.velocity, t[g], broadcast<L>(path.center));
    }
    for (std::size_t k = 0; k < path.count; ++k) {
      const Oscillation o = path.oscillations[k];
#pragma GCC unroll 4
      for (std::size_t g = 0; g < group; ++g) {
        // Rounded as in MotionPath::at: late in a motion this is the larger part of its rounding errors.
        const L argument = rounded<L>(o.rate * t[g]) + o.phase;
        position[g] = fma(o.amplitude, sine(argument), position[g]);
      }
    }
#pragma GCC unroll 4
    for (std::size_t g = 0; g < group; ++g) store(to + i + g * lanes, position[g]);
  }
}

template <class L>
void displace(const double* row, double shift, double* to) {
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>) store(to + i, load<L>(row + i) + shift);
}

template <class L>
void mix(std::size_t n, const double* matrix, const double* from, double* to) {
  for (std::size_t row = 0; row < n; ++row)
    for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
      L sum{};
      for (std::size_t column = 0; column < n; ++column) {
        const double factor = matrix[row * n + column];
        if (factor != 0) sum = fma(factor, load<L>(from + column * batch_size + i), sum);
      }
      store(to + row * batch_size + i, sum);
    }
}

template <class L>
[[gnu::always_inline]] inline L floor(const L& x) {
  L rounded_x;
#pragma GCC unroll 8
  for (std::size_t i = 0; i < lane_count<L>; ++i) rounded_x[i] = __builtin_floor(x[i]);
  return rounded_x;
}

template <class L>
bool quantize(const Quantizer& q, const double* position, double* counts, double* measured) {
  const double half = q.down ? 0 : 0.5, inverse = 1 / q.resolution;
  Bits<L> outside{};
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>) {
    const L count = floor(over(load<L>(position + i), q.resolution, inverse) + half);
    outside |= ~(abs(count) <= 0x1p53);
    store(counts + i, count);
    store(measured + i, count * q.resolution);
  }
  return !any<L>(outside);
}

template <class L>
bool within(const double* row, double factor, double limit) {
  Bits<L> inside = ~Bits<L>{};
  for (std::size_t i = 0; i < batch_size; i += lane_count<L>)
    inside &= factor * abs(load<L>(row + i)) <= limit;
  return !any<L>(~inside);
}

/// `group` vectors of channels, whose sums stay in registers.
template <class L, int group, bool peaks>
[[gnu::always_inline]] inline void tally_on(const double* in, std::size_t stride, std::size_t rows,
                                            std::size_t c, bool fresh, const ChannelTally& t) {
  L shift[group], sum[group], squares[group], peak[group];
#pragma GCC unroll 8
  for (int g = 0; g < group; ++g) {
    const std::size_t at = c + g * lane_count<L>;
    if (fresh) store(t.shift + at, load<L>(in + at));
    shift[g] = load<L>(t.shift + at);
    sum[g] = load<L>(t.sum + at);
    squares[g] = load<L>(t.squares + at);
    peak[g] = peaks ? load<L>(t.peak + at) : L{};
  }
  for (std::size_t row = 0; row < rows; ++row) {
#pragma GCC unroll 8
    for (int g = 0; g < group; ++g) {
      const L value = load<L>(in + row * stride + c + g * lane_count<L>), deviation = value - shift[g];
      sum[g] += deviation;
      squares[g] = fma(deviation, deviation, squares[g]);
      if constexpr (peaks) peak[g] = max(abs(value), peak[g]);
    }
  }
#pragma GCC unroll 8
  for (int g = 0; g < group; ++g) {
    const std::size_t at = c + g * lane_count<L>;
    store(t.sum + at, sum[g]);
    store(t.squares + at, squares[g]);
    if constexpr (peaks) store(t.peak + at, peak[g]);
  }
}

template <class L>
void tally(const double* in, std::size_t stride, std::size_t rows, std::size_t width, std::size_t peaks,
           bool fresh, const ChannelTally& t) {
  in_groups<4, L>(0, width, [&]<int group>(std::size_t c) {
    c < peaks ? tally_on<L, group, true>(in, stride, rows, c, fresh, t)
              : tally_on<L, group, false>(in, stride, rows, c, fresh, t);
  });
}

}  // namespace
}  // namespace qerr::lanes

namespace qerr {

template <>
const SimulationKernels& compiled_kernels<SimulationKernels, lanes::compiled_set>() {
  using namespace lanes;
  using L = CompiledLanes;
  static constexpr SimulationKernels kernels{lane_count<L>, errors_scratch_size<L>,
                                             times<L>,      positions<L>,
                                             displace<L>,   mix<L>,
                                             quantize<L>,   within<L>,
                                             sines<L>,      errors<L>,
                                             tally<L>};
  return kernels;
}

}  // namespace qerr
