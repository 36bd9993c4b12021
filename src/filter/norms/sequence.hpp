#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "filter/norms/modes.hpp"

namespace qerr {

/// How fast each mode decays.
class Decays {
 public:
  explicit Decays(const std::vector<Mode>& modes);
  void moduli(std::int64_t k, std::vector<double>& moduli) const;  ///< upper bounds of |z|^k of all modes
  double modulus(std::size_t mode, std::int64_t k) const;          ///< an upper bound of |z|^k
  double one_minus_modulus(std::size_t mode) const;

 private:
  std::vector<double> decay_;  // lower bounds of -log |z|
};

/// A bound of sum |x_k| over k >= first of one mode; infinite where its terms do not yet decrease.
double tail(const Mode&, std::int64_t first);

/// Powers z^k of all modes, each by a few products of tabulated ones, which are computed with 256 bits: z of
/// a slow pole has lost most digits of its decay, which its powers show.
class Powers : public Decays {
 public:
  explicit Powers(const std::vector<Mode>& modes);
  std::vector<ComplexBall> proven(std::int64_t k) const;  ///< z^k of all modes, enclosed
  void quick(std::int64_t k,
             std::vector<std::complex<double>>& powers) const;  ///< z^k of all modes, in doubles

 private:
  std::vector<std::vector<ComplexBall>> proven_;          // z^(j 16^i) at 16 i + j
  std::vector<std::vector<std::complex<double>>> quick_;  // the same
};

/// The largest sample of a modal sequence: exact in a product of balls, and far from overflow.
inline constexpr std::int64_t latest_sample = std::int64_t{1} << 58;

/// A modal sequence x_k = sum_i sum_m c_im C(k + m - 1, m - 1) z_i^k: an impulse response, its differences or
/// its sum. Keeps a reference to the powers of its modes, which must outlive it.
class Sequence {
 public:
  Sequence(std::vector<Mode> modes, const Powers& powers);
  RealBall at(std::int64_t k) const { return at(k, powers_->proven(k)); }
  RealBall at(std::int64_t k, const std::vector<ComplexBall>& powers) const;  ///< @param powers  of k
  /// x_k within 1e-12 of bound(k, k), if `accurate`. @param powers  quick ones of k
  double quick_at(std::int64_t k, const std::vector<std::complex<double>>& powers) const;
  double bound(std::int64_t first, std::int64_t last) const;  ///< of |x_k| over first..last
  /// Bound of |x_k| up to last. @param moduli  of first
  double bound(const std::vector<double>& moduli, std::int64_t last) const;
  double tail(std::int64_t first) const;  ///< of sum |x_k| over k >= first
  /// Whether the coefficients have relative errors below 1e-14 of their contribution to `bound`.
  bool accurate() const;
  double mean_multiplicity() const;                           ///< of the modes
  Sequence difference() const;                                ///< x_k - x_{k-1}
  Sequence transient_of_sum() const;                          ///< U with U_k - U_{k-1} = x_k, U -> 0
  Sequence plus(double factor, const Sequence& other) const;  ///< x + factor y, of the same modes

 private:
  struct Coefficient {
    double re, im;
    double size;  // upper bound of |c|
  };
  std::vector<Mode> modes_;
  const Powers* powers_;
  std::vector<std::vector<Coefficient>> rounded_;  // doubled for a pair
};

/// The differences x, D x, D^2 x, ... of a modal sequence, D x_k = x_k - x_{k-1}, which bound how it varies.
class Differences {
 public:
  explicit Differences(const Sequence& x);
  /// D x.
  const Sequence& first() const { return list_[1]; }
  const Sequence& second() const { return list_[2]; }
  /// A bound of |x_k - x_middle| over first..end-1, by the Newton series x_{m+i} = sum_j C(i+j-1, j) (D^j
  /// x)_m: it includes the cancellation of the modes, which makes the bounds of a low-pass of high order,
  /// whose response starts as t^n, much too large.
  /// @param powers  of middle
  double variation(std::int64_t first, std::int64_t end, std::int64_t middle,
                   const std::vector<ComplexBall>& powers) const;

 private:
  std::vector<Sequence> list_;
};

}  // namespace qerr
