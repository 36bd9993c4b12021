#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "filter/norms/modes.hpp"

namespace qerr {

/// The powers z^(2^i) of every mode, so that any z^k costs a few products.
class Powers {
 public:
  explicit Powers(const std::vector<Mode>& modes);
  ComplexBall proven(std::size_t mode, std::int64_t k) const;
  void quick(std::int64_t k, std::vector<std::complex<double>>& powers) const;  ///< of all modes
  void moduli(std::int64_t k, std::vector<double>& moduli) const;  ///< upper bounds of |z|^k, of all modes
  double modulus(std::size_t mode, std::int64_t k) const;          ///< an upper bound of |z|^k
  double one_minus_modulus(std::size_t mode) const;

 private:
  std::vector<std::vector<ComplexBall>> squarings_;
  std::vector<std::vector<std::complex<double>>> quick_;  // z^(j 16^i) at 16 i + j
  std::vector<double> decay_;                             // -log |z|, from below
};

/// A sequence sum_i sum_m c_im C(k + m - 1, m - 1) z_i^k: an impulse response, its differences or its sum.
class Sequence {
 public:
  Sequence(std::vector<Mode> modes, const Powers& powers);
  RealBall at(std::int64_t k) const;
  /// To 1e-12 of bound(k, k), if `trusted`; `powers` are those of k.
  double quick_at(std::int64_t k, const std::vector<std::complex<double>>& powers) const;
  double bound(std::int64_t first, std::int64_t last) const;  ///< of |.| over first..last
  /// The same, where `moduli` are those of first.
  double bound(const std::vector<double>& moduli, std::int64_t last) const;
  double tail(std::int64_t first) const;  ///< of sum |.| over k >= first; infinite where not yet decaying
  /// Whether the coefficients are known to 1e-14 of their share of `bound`, as `quick_at` needs.
  bool trusted() const;
  Sequence difference() const;        ///< x_k - x_{k-1}
  Sequence transient_of_sum() const;  ///< U with U_k - U_{k-1} = x_k, U -> 0

 private:
  struct Coefficient {
    double re, im;
    double size;  // upper bound of |c|
  };
  std::vector<Mode> modes_;
  const Powers* powers_;
  std::vector<std::vector<Coefficient>> rounded_;  // twice them, of a pair
};

}  // namespace qerr
