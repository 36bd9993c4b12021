#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "filter/norms/modes.hpp"

namespace qerr {

/// Powers z^k of all modes, each by a few products of tabulated ones.
class Powers {
 public:
  explicit Powers(const std::vector<Mode>& modes);
  ComplexBall proven(std::size_t mode, std::int64_t k) const;  ///< z^k, enclosed
  void quick(std::int64_t k,
             std::vector<std::complex<double>>& powers) const;     ///< z^k of all modes, in doubles
  void moduli(std::int64_t k, std::vector<double>& moduli) const;  ///< upper bounds of |z|^k of all modes
  double modulus(std::size_t mode, std::int64_t k) const;          ///< an upper bound of |z|^k
  double one_minus_modulus(std::size_t mode) const;

 private:
  std::vector<std::vector<ComplexBall>> squarings_;
  std::vector<std::vector<std::complex<double>>> quick_;  // z^(j 16^i) at 16 i + j
  std::vector<double> decay_;                             // lower bounds of -log |z|
};

/// A modal sequence x_k = sum_i sum_m c_im C(k + m - 1, m - 1) z_i^k: an impulse response, its differences or
/// its sum. Keeps a reference to the powers of its modes, which must outlive it.
class Sequence {
 public:
  Sequence(std::vector<Mode> modes, const Powers& powers);
  RealBall at(std::int64_t k) const;
  /// x_k within 1e-12 of bound(k, k), if `accurate`. @param powers  quick ones of k
  double quick_at(std::int64_t k, const std::vector<std::complex<double>>& powers) const;
  double bound(std::int64_t first, std::int64_t last) const;  ///< of |x_k| over first..last
  /// The same. @param moduli  of first
  double bound(const std::vector<double>& moduli, std::int64_t last) const;
  double tail(std::int64_t first) const;  ///< of sum |x_k| over k >= first; infinite where not yet decaying
  /// Whether the coefficients have relative errors below 1e-14 of their contribution to `bound`.
  bool accurate() const;
  Sequence difference() const;        ///< x_k - x_{k-1}
  Sequence transient_of_sum() const;  ///< U with U_k - U_{k-1} = x_k, U -> 0

 private:
  struct Coefficient {
    double re, im;
    double size;  // upper bound of |c|
  };
  std::vector<Mode> modes_;
  const Powers* powers_;
  std::vector<std::vector<Coefficient>> rounded_;  // doubled for a pair
};

}  // namespace qerr
