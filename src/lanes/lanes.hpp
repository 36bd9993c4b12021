#pragma once

#include <cstddef>
#include <cstdint>

/// Vectors of doubles: one configuration, or one instant, per lane.
///
/// `Lanes<n>` is the compiler's vector of n doubles: +, -, *, / and comparisons act on every lane, a scalar
/// is broadcast. The functions are templates over n; the flags of the translation unit that includes them
/// decide on the instructions. Everything has internal linkage: with external linkage the linker could keep
/// the AVX-512 code of one translation unit for the calls of another.
namespace qerr::lanes {
namespace {

template <int n>
struct LanesOf {
  typedef double type __attribute__((vector_size(n * sizeof(double))));
};
template <int n>
using Lanes = typename LanesOf<n>::type;

/// Signed 64-bit integers, as many as L has lanes; also the result of a comparison: -1 true, 0 false.
template <class L>
using Bits = decltype(L{} < L{});

template <class L>
constexpr std::size_t lane_count = sizeof(L) / sizeof(double);

template <class L>
[[gnu::always_inline]] inline L broadcast(double value) {
  return value - L{};  // exact, also of -0
}

template <class L>
[[gnu::always_inline]] inline L load(const double* from) {
  L lanes;
  __builtin_memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

template <class L>
[[gnu::always_inline]] inline void store(double* to, const L& lanes) {
  __builtin_memcpy(to, &lanes, sizeof lanes);
}

/// a b + c; fused (one rounding) where the instruction set of the translation unit has it.
template <class A, class B, class C>
[[gnu::always_inline]] inline auto fma(const A& a, const B& b, const C& c) {
  return a * b + c;
}

template <class L>
[[gnu::always_inline]] inline L abs(const L& x) {
  constexpr auto magnitude = ~(std::int64_t{1} << 63);
  return __builtin_bit_cast(L, __builtin_bit_cast(Bits<L>, x) & magnitude);
}

template <class L>
[[gnu::always_inline]] inline L max(const L& a, const L& b) {
  return a > b ? a : b;
}

template <class L>
[[gnu::always_inline]] inline L min(const L& a, const L& b) {
  return a < b ? a : b;
}

template <class L>
[[gnu::always_inline]] inline L sqrt(const L& x) {
  L root;
  for (std::size_t i = 0; i < lane_count<L>; ++i) root[i] = __builtin_sqrt(x[i]);
  return root;
}

/// x, opaque to the optimizer: a product is rounded before it is added, not fused.
template <class L>
[[gnu::always_inline]] inline L rounded(L x) {
#if defined(__x86_64__)
  asm("" : "+x"(x));
#elif defined(__aarch64__)
  if constexpr (sizeof(L) <= 16) asm("" : "+w"(x));
#endif
  return x;
}

/// Calls kernel<group>(first lane) for groups of vectors of a row of `width` numbers, the largest groups
/// first. The vectors of a group are independent, so that their recursions over the rows overlap in the
/// pipeline.
template <int group, class L, class Kernel>
[[gnu::always_inline]] inline void in_groups(std::size_t first, std::size_t width, Kernel kernel) {
  for (; first + group * lane_count<L> <= width; first += group * lane_count<L>)
    kernel.template operator()<group>(first);
  if constexpr (group > 1)
    if (first < width) in_groups<group - 1, L>(first, width, kernel);
}

/// c0 + c1 x + ... by Horner's rule: the fewest operations; their latency is hidden by those of other joints.
template <class L, class... More>
[[gnu::always_inline]] inline L polynomial(const L& x, double c0, More... more) {
  if constexpr (sizeof...(more) == 0)
    return broadcast<L>(c0);
  else
    return fma(x, polynomial(x, more...), broadcast<L>(c0));
}

template <class L>
struct SineCosine {
  L sine, cosine;
};

/// Largest |angle| for which `sincos` keeps its accuracy [rad].
constexpr double largest_angle = 1 << 20;

/// Sine and cosine of an angle within +-pi/4, by polynomials of least largest error (degrees 13 and
/// 12; 1.6e-18 and 5.2e-17).
template <class L>
[[gnu::always_inline]] inline SineCosine<L> sincos_near_zero(const L& r) {
  const L s = r * r;
  const L sine = polynomial(s, -0x1.555555555553dp-3, 0x1.111111110eb1ap-7, -0x1.a01a019ab4225p-13,
                            0x1.71de3474f29d8p-19, -0x1.ae5db422ca693p-26, 0x1.5d64b1075c7cfp-33);
  const L cosine = polynomial(s, -0x1.fffffffffffa3p-2, 0x1.555555554f952p-5, -0x1.6c16c1648a935p-10,
                              0x1.a019f88414f01p-16, -0x1.27df6c04786a3p-22, 0x1.1b95fdf5dacd4p-29);
  return {fma(s * r, sine, r), fma(s, cosine, broadcast<L>(1))};
}

/// Sine and cosine after adding n quarter turns; the last two bits of the double hold n mod 4.
template <class L>
[[gnu::always_inline]] inline SineCosine<L> add_quarter_turns(const SineCosine<L>& a, const L& n) {
  const Bits<L> quarter = __builtin_bit_cast(Bits<L>, n);
  const Bits<L> negative_sine = (quarter & 2) << 62, negative_cosine = ((quarter + 1) & 2) << 62;
  const Bits<L> odd = quarter << 63;
  const L sine = odd < 0 ? a.cosine : a.sine, cosine = odd < 0 ? a.sine : a.cosine;
  return {__builtin_bit_cast(L, __builtin_bit_cast(Bits<L>, sine) ^ negative_sine),
          __builtin_bit_cast(L, __builtin_bit_cast(Bits<L>, cosine) ^ negative_cosine)};
}

/// Sine and cosine of the angle y pi/2, absolute error 1.6e-16.
///
/// As `sincos`, but the reduction y - round(y) is exact. Converting radians to quarter turns costs one
/// rounding of the angle.
template <class L>
[[gnu::always_inline]] inline SineCosine<L> sincos_of_quarters(const L& y) {
  constexpr double shift = 0x1.8p52;  // as below
  const L shifted = y + shift, part = y - (shifted - shift), s = part * part;
  const L sine =
      polynomial(s, 0x1.921fb54442d18p+0, -0x1.4abbce625be3bp-1, 0x1.466bc67757d80p-4, -0x1.32d2cce230e2ap-8,
                 0x1.50782f2f4eb80p-13, -0x1.e2ffddcca7a9fp-19, 0x1.e3c3709f5c019p-25);
  const L cosine = polynomial(s, 1, -0x1.3bd3cc9be45a5p+0, 0x1.03c1f081b14bep-2, -0x1.55d3c7dcb5f56p-6,
                              0x1.e1f4fbfc011a2p-11, -0x1.a6ca009623920p-16, 0x1.f3ef423289948p-22);
  return add_quarter_turns(SineCosine<L>{part * sine, cosine}, shifted);
}

/// Sine and cosine of an angle in radians, absolute error 1.6e-16 (2.7e-16 without fused multiply-add).
///
/// Cody-Waite reduction r = angle - n pi/2 with pi/2 in parts, so that cancellation loses no digits, then
/// `sincos_near_zero`. The angle's own last place limits the result (1e-10 at 1e6 rad); beyond
/// `largest_angle` the error is some units of that place.
template <class L>
[[gnu::always_inline]] inline SineCosine<L> sincos(const L& angle) {
  constexpr double two_over_pi = 0x1.45f306dc9c883p-1, shift = 0x1.8p52;
  // Adding 1.5 2^52 rounds to an integer, held by the last bits of the sum.
  const L shifted = fma(angle, two_over_pi, broadcast<L>(shift));
  const L n = shifted - shift;
#if defined(__FMA__) || defined(__aarch64__)
  const L r = fma(n, -0x1.1a62633145c07p-54, fma(n, -0x1.921fb54442d18p+0, angle));
#else  // parts of 33 bits: n times a part is exact
  const L r = ((angle - n * 0x1.921fb544p+0) - n * 0x1.0b4611a6p-34) - n * 0x1.3198a2e037073p-69;
#endif
  return add_quarter_turns(sincos_near_zero(r), shifted);
}

}  // namespace

namespace {

template <class L>
struct WordsOf {
  typedef std::uint64_t type __attribute__((vector_size(sizeof(L))));
};
/// Unsigned 64-bit integers, as many as L has lanes.
template <class L>
using Words = typename WordsOf<L>::type;

/// `mixed_bits` of core/random.hpp in every lane.
template <class W>
[[gnu::always_inline]] inline W mixed(W z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

}  // namespace
}  // namespace qerr::lanes
