#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "filter/norms/multiprecision.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

using RealBall = Ball<DoubleDouble>;
using ComplexBall = ComplexOf<RealBall>;

// A complex ball grows by up to the square root of 2 in every product: of 2^60 samples that takes 90 bits.
using FineBall = Ball<Binary256>;
using FineComplex = ComplexOf<FineBall>;

/// The ball about the nearest double-double that contains x.
RealBall rounded(const FineBall& x);
inline ComplexBall rounded(const FineComplex& x) { return {rounded(x.re), rounded(x.im)}; }

/// z^n.
FineComplex power(FineComplex z, std::int64_t n);

/// |arg z|.
inline double angle(const FineComplex& z) {
  return std::abs(std::atan2(static_cast<double>(z.im.mid()), static_cast<double>(z.re.mid())));
}

inline ComplexBall exact_ball(const ComplexDoubleDouble& x) { return {RealBall(x.re), RealBall(x.im)}; }
/// An upper bound of |x|.
inline double largest(const ComplexBall& x) {
  return std::hypot(x.re.largest(), x.im.largest()) * (1 + 0x1p-45);
}

/// A lower bound of 1 - |z|: half of 1 - |z|^2 = 2 Re(1 - z) - |1 - z|^2, which does not cancel.
inline double one_minus_modulus(const ComplexBall& one_minus_z) {
  return 0.5 * (RealBall(2.0) * one_minus_z.re - norm(one_minus_z)).smallest();
}

/// A pole in w; of a conjugate pair only the upper one is listed.
struct Pole {
  ComplexDoubleDouble w;
  int multiplicity = 1;
  bool real() const { return w.im == DoubleDouble(0); }
  /// z = (1 + w)/(1 - w).
  ComplexDoubleDouble z() const { return (ComplexDoubleDouble(1.0) + w) / (ComplexDoubleDouble(1.0) - w); }
};

/// The poles of a filter in double-double.
struct Poles {
  std::vector<Pole> list;  ///< poles at z = 0 are those with w = -1
  double change = 0;       ///< ||H' - H||_1 <= change ||H'||_1 for the filter H' with exactly these poles
};

/// The poles of all sections. Poles within rounding of each other are merged into a multiple one.
Poles poles(const Filter&);

/// The contribution of one pole to h_k: sum_m c_m C(k + m - 1, m - 1) z^k over m = 1..c.size(), plus its
/// conjugate where `pair`.
struct Mode {
  FineComplex z;            ///< (1 + w)/(1 - w)
  ComplexBall one_minus_z;  ///< without cancellation for a slow pole
  bool pair = false;
  std::vector<ComplexBall> c;
};

/// Partial fractions of the filter: h_k is the sum of the modes for k >= from.
struct Modes {
  std::vector<Mode> modes;
  std::size_t from = 0;
};

Modes partial_fractions(const Filter&, const std::vector<Pole>&);

/// Every step-th sample of a mode: k -> x_{step k + offset}.
Mode decimated(const Mode&, std::int64_t step, std::int64_t offset);

}  // namespace qerr
