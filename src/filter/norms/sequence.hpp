#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "filter/norms/modes.hpp"
#include "filter/norms/sequence.hpp"
#include "filter/run/cascade.hpp"
#include "qerr/filter/filter.hpp"

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

/// sum |x_k| over first..next-1, within `error` of `sum`.
struct RunsSum {
  RealBall sum;
  double error = 0;
  std::int64_t next = 0;
  std::int64_t visits = 0;  ///< remaining of the given ones
};

/// Sums |x_k| over first..end-1 by its runs of one sign, each a difference of two values of the sum of x: the
/// work grows with the number of sign changes and not with the length. Stops early after `visits` blocks.
/// @param powers  of the modes of x
/// @param scale  lower bound of the norm: blocks are negligible relative to it
/// @pre x.accurate()
RunsSum sum_of_runs(const Sequence& x, const Powers& powers, double scale, std::int64_t first,
                    std::int64_t end, std::int64_t visits);

/// Relative error of a sampled sum against the sum of the sizes of all modes.
inline constexpr double sampling_error = 1.5e-14;

/// sum |x_k| over first..end-1 of simple modes, sample by sample in doubles, within `error` of `sum`: about 1
/// ns a sample and mode.
struct SampledSum {
  double sum = 0;
  double error = 0;
};

SampledSum sampled_sum(const std::vector<Mode>& modes, const Powers& powers, std::int64_t first,
                       std::int64_t end);

/// sum |2 Re(c z^k)| over from <= k < end for a simple conjugate pair of poles, proven.
///
/// The signs of the terms form a Sturmian word, which Euclid's algorithm sums in O(log(end)) steps, however
/// many periods of the resonance there are.
/// @pre mode.pair, mode.c has one element, 0 <= from < end <= 2^52
RealBall resonance_sum(const Mode& mode, std::int64_t from, std::int64_t end);

/// Enclosure of sum |x_k| over k >= from: `sum` - `error` to `sum` + `error` + `beyond`.
struct TailSum {
  RealBall sum;
  double error = 0;
  double beyond = 0;  ///< upper bound of the terms that were not summed
};

/// The enclosure of the sum over both ranges.
TailSum operator+(TailSum, const TailSum&);

/// Sums a modal expansion of an impulse response from a sample to infinity.
///
/// By runs of one sign (`sum_of_runs`), or sample by sample where these are few (`sampled_sum`). A mode is
/// dropped when its remaining sum is negligible; a resonance that decays much more slowly than the others
/// finally remains alone and is summed by `resonance_sum`. What exceeds the limit of work is only bounded.
/// @param scale  lower bound of the norm: parts are negligible relative to it
/// @param work  limit of blocks of sign runs times modes
TailSum tail_sum(std::vector<Mode> modes, std::int64_t from, double scale, std::int64_t work);

/// The step for which every step-th sample, for each of the `step` first samples a sequence of its own, has
/// the fewest changes of sign: 2 for poles near z = -1 beside others near 1, n for poles near the n-th roots
/// of 1. 1 where no step up to 240 is better.
std::int64_t decimation(const std::vector<Mode>& modes, std::int64_t from, double scale);

/// Relative allowance for a norm of a designed filter against the norm of the ideal one: a design computes
/// its coefficients with a few roundings to double. 0 for filters that are not designed by a family.
inline double design_rounding(const Filter& filter) {
  constexpr double of_section = 1e-15;
  return filter.designed ? of_section * static_cast<double>(1 + filter.sections.size()) : 0;
}

/// An upper bound of sqrt(sum (1 + lift)^(2k) h_k^2), the H2 norm of H(z/(1 + lift)), within 10 % of it;
/// infinite unless every pole is proven to be inside |z| < 1/(1 + lift).
/// @pre no taps
double lifted_norm(const Filter&, double lift);

/// sum |h_k| over k < count, and a proven bound of its rounding error.
struct PartialSum {
  double sum = 0;
  double error = 0;
};

/// Sums |h_k| sample by sample in double-double, with a running bound of the rounding errors.
class DirectSum {
 public:
  /// @pre no taps, at least one section
  /// @param lift  (1 + lift) times the largest pole modulus is below 1
  DirectSum(const Filter&, double lift);

  PartialSum sum(std::int64_t count) const;
  /// Upper bound of sum |h_k| over k >= from (Cauchy and Schwarz).
  double tail(std::int64_t from) const;

 private:
  /// ||.||_1 from a disturbance of a section to the filter's output.
  struct Sensitivity {
    double input = 0, first_state = 0, second_state = 0, output = 0;
  };
  FilterPlan<DoubleDouble> plan_;
  std::vector<Sensitivity> sensitivity_;
  double lift_ = 0;
  double lifted_ = 0;  // ||H||_2, lifted
};

}  // namespace qerr
