#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "filter/norms/sequence.hpp"

namespace qerr {

namespace {

constexpr double taylor_visits = 20;  // time of `sum_by_taylor` relative to a block of simple modes
// Below this ratio of |x| to its bound, bisection by the bound takes too many blocks.
constexpr double cancelled = 0.01;

/// Sum of |x_k| by runs of one sign, each a difference of two values of U = transient_of_sum.
///
/// sum s_k x_k <= sum |x_k| for all signs s_k: a wrong sign of a value near 0 does not affect the lower
/// bound, and the upper bound by twice that value.
class SignRuns {
 public:
  SignRuns(const Sequence& x, const Powers& powers, double scale, std::int64_t visits)
      : x_(x),
        sum_(x.transient_of_sum()),
        differences_(x),
        powers_(powers),
        scale_(scale),
        visits_(visits),
        visits_of_taylor_(static_cast<std::int64_t>(taylor_visits * x.mean_multiplicity())) {}

  /// Sums over first..end-1; stops early when no visits remain.
  void cover(std::int64_t first, std::int64_t end) {
    start_ = next_ = first;
    sum_before_ = sum_.at(first - 1);
    visit(first, end);
    close(next_);
  }
  RunsSum result() const { return {total_, 2 * error_, next_, std::max<std::int64_t>(visits_, 0)}; }

 private:
  bool spent() { return --visits_ < 0; }

  /// The sign of x_k. Where it is uncertain, `count` values up to |x_k| are added to the error.
  int sign_at(std::int64_t k, std::int64_t count) {
    powers_.quick(k, power_);
    const double quick = x_.quick_at(k, power_);
    if (std::abs(quick) > 1e-12 * x_.bound(k, k)) return quick < 0 ? -1 : 1;
    const RealBall x = x_.at(k);
    if (!x.above_zero() && !x.below_zero()) error_ += x.largest() * static_cast<double>(count);
    return x.mid() < DoubleDouble(0) ? -1 : 1;
  }

  void visit(std::int64_t first, std::int64_t end) {
    if (next_ != first) return;  // stopped before this block
    if (spent()) return;
    if (end - first <= 3) {
      for (std::int64_t k = first; k < end; ++k) extend(k + 1, sign_at(k, 1));
      return;
    }
    const std::int64_t middle = first + (end - first) / 2;
    const double radius = static_cast<double>(std::max(middle - first, end - 1 - middle)) * 1.001;
    powers_.quick(middle, power_);
    powers_.moduli(first, moduli_);
    const double x = x_.quick_at(middle, power_), size = x_.bound(moduli_, middle);
    const double steepest = differences_.first().bound(moduli_, end - 1);
    if (std::abs(x) > radius * steepest + 1e-12 * size) {
      extend(end, x < 0 ? -1 : 1);
      return;
    }
    const double slope = differences_.first().quick_at(middle, power_);
    if (std::abs(slope) > radius * differences_.second().bound(moduli_, end - 1) + 1e-12 * steepest) {
      monotone(first, end);
      return;
    }
    if (std::abs(x) < cancelled * size && sum_by_taylor(first, end, middle)) return;
    visit(first, middle);
    visit(middle, end);
  }

  /// Where the modes almost cancel the other bounds are much too large.
  /// @returns whether the block has one sign, or is negligible; then it is summed
  bool sum_by_taylor(std::int64_t first, std::int64_t end, std::int64_t middle) {
    visits_ -= visits_of_taylor_;
    const std::vector<ComplexBall> powers = powers_.proven(middle);
    const RealBall center = x_.at(middle, powers);
    const double change = differences_.variation(first, end, middle, powers);
    const double total = (center.largest() + change) * static_cast<double>(end - first);
    if (center.smallest() > change) {
      extend(end, center.mid() < DoubleDouble(0) ? -1 : 1);
    } else if (total <= 1e-18 * scale_) {
      error_ += total;
      extend(end, sign_ == 0 ? 1 : sign_);
    } else {
      return false;
    }
    return true;
  }

  /// x is monotone on the block: at most one change of sign, found by bisection.
  void monotone(std::int64_t first, std::int64_t end) {
    const int left = sign_at(first, end - first), right = sign_at(end - 1, end - first);
    if (left != right) {
      std::int64_t low = first, high = end - 1;
      while (high - low > 1) {
        const std::int64_t k = low + (high - low) / 2;
        (sign_at(k, high - low) == left ? low : high) = k;
      }
      extend(high, left);
    }
    extend(end, right);
  }

  void extend(std::int64_t end, int sign) {
    if (sign != sign_) {
      close(next_);
      sign_ = sign;
      start_ = next_;
    }
    next_ = end;
  }

  void close(std::int64_t end) {
    if (end <= start_) return;
    const RealBall sum = sum_.at(end - 1), run = sum - sum_before_;
    sum_before_ = sum;
    total_ += sign_ < 0 ? -run : run;
    start_ = end;
  }

  Sequence x_, sum_;
  Differences differences_;
  const Powers& powers_;
  std::vector<std::complex<double>> power_;  // z^k of all modes at the current sample
  std::vector<double> moduli_;
  double scale_;
  RealBall total_;
  RealBall sum_before_;  // before the current run
  double error_ = 0;
  std::int64_t start_ = 0;
  std::int64_t next_ = 0;
  int sign_ = 0;
  std::int64_t visits_;  // remaining blocks
  std::int64_t visits_of_taylor_;
};

constexpr std::size_t block = 256;

/// z^j, j = 0 .. block-1, each rounded once.
struct Table {
  std::array<double, block> re, im;
};

std::vector<Table> tables_of(std::size_t modes, const Powers& powers) {
  std::vector<Table> tables(modes);
  for (std::size_t j = 0; j < block; ++j) {
    const std::vector<ComplexBall> power = powers.proven(static_cast<std::int64_t>(j));
    for (std::size_t i = 0; i < modes; ++i) {
      tables[i].re[j] = power[i].re.mid().hi;
      tables[i].im[j] = power[i].im.mid().hi;
    }
  }
  return tables;
}

// A term is the product of the coefficient, at most 15 tabulated powers and one of the table. Each is rounded
// by less than 2^-52, a complex product by sqrt(5) 2^-53 (Brent, Percival and Zimmermann 2007). The sum of a
// block adds 2^-53 for each mode, and for each sample and part of its two stages.
constexpr std::size_t parts = 16;
constexpr double term_error = 17 * (2.24 + 2) * 0x1p-53;

double absolute_sum(const std::array<double, block>& x, std::size_t count) {
  double sum = 0;
  for (std::size_t start = 0; start < count; start += block / parts) {
    double part = 0;
    for (std::size_t j = start; j < std::min(count, start + block / parts); ++j) part += std::abs(x[j]);
    sum += part;
  }
  return sum;
}

/// An integer below 2^500 in magnitude: sums and products are exact in 1024 bits, and so is the floor of a
/// quotient, which is either an integer or at least 1/divisor away from one.
using Integer = Binary1024;

Integer quotient(const Integer& x, const Integer& y) { return floor(x / y); }
Integer modulo(const Integer& x, const Integer& y) { return x - y * quotient(x, y); }

/// The affine map of a word over {up, on}: (p, sum) -> (factor p, sum + share p). Words are multiplied from
/// left to right.
struct Word {
  FineComplex factor{1.0};
  FineComplex share{0.0};
};

Word operator*(const Word& x, const Word& y) { return {x.factor * y.factor, x.share + x.factor * y.share}; }

Word power(Word x, Integer n) {
  Word r;
  while (n > 0) {
    const Integer half = quotient(n, 2);
    if (n != 2 * half) r = r * x;
    x = x * x;
    n = half;
  }
  return r;
}

/// The word of the line (p x + b)/q over 0 < x <= n: for every x first an `up` for each integer that the line
/// has crossed since x - 1, then an `on`; 0 <= b < q. Euclid's algorithm, exchanging up and on.
Word line(const Integer& p, const Integer& q, const Integer& b, const Integer& n, const Word& up,
          const Word& on) {
  if (n == 0) return {};
  if (p >= q) return line(modulo(p, q), q, b, n, up, power(up, quotient(p, q)) * on);
  const Integer crossings = quotient(p * n + b, q);
  if (crossings == 0) return power(on, n);
  const Integer gap = q - b - 1;
  return power(on, quotient(gap, p)) * up * line(q, p, modulo(gap, p), crossings - 1, on, up) *
         power(on, n - quotient(q * crossings - b - 1, p));
}

constexpr int fraction_bits = 200;

/// floor(2^200 x), |x| < 2^50.
Integer fixed_point(Binary256 x) {
  Integer sum = 0;
  while (x != 0) {
    const double part = static_cast<double>(x);
    sum += part;
    x -= part;
  }
  return floor(ldexp(sum, fraction_bits));
}

Binary256 exact(const DoubleDouble& x) { return Binary256(x.hi) + Binary256(x.lo); }

FineBall fine(const RealBall& x) { return FineBall(exact(x.mid()), x.rad()); }

constexpr double negligible_tail = 1e-18;   // remaining sum of a dropped mode relative to the norm
constexpr double blocks_per_run = 8;        // of an oscillation, its sums included
constexpr double samples_per_block = 300;   // that sampled_sum takes in the time of a block
constexpr double precise_sampling = 1e-13;  // error of a sampled sum relative to the norm
constexpr double many_runs = 300;           // above, dropping decayed modes saves time
constexpr std::int64_t longest = latest_sample / 2;

/// A sample from which a mode is negligible_tail, at most a quarter later than the first one.
std::int64_t end_of(const Mode& mode, std::int64_t from, double scale) {
  std::int64_t end = from + 16;
  while (end < longest && !(tail(mode, end) <= negligible_tail * scale)) end += end / 4;
  return end;
}

/// Approximate number of sign changes of the modes over from..end.
double runs_of(const std::vector<Mode>& modes, std::int64_t from, std::int64_t end) {
  double fastest = 0;
  for (const Mode& m : modes) fastest = std::max(fastest, angle(m.z));
  return fastest * static_cast<double>(end - from) / std::numbers::pi;
}

/// Removes the modes that have decayed. @returns a bound of their remaining sum
double drop_decayed(std::vector<Mode>& modes, std::vector<std::int64_t>& ends, std::int64_t from) {
  double dropped = 0;
  for (std::size_t i = modes.size(); i-- > 0;) {
    if (ends[i] > from) continue;
    dropped += tail(modes[i], from);
    modes.erase(modes.begin() + i);
    ends.erase(ends.begin() + i);
  }
  return dropped;
}

bool one_resonance(const std::vector<Mode>& modes) {
  return modes.size() == 1 && modes[0].pair && modes[0].c.size() == 1;
}

bool simple(const std::vector<Mode>& modes) {
  return std::ranges::all_of(modes, [](const Mode& m) { return m.c.size() == 1; });
}

/// For too many runs: the sum of the slowest mode, if it is a resonance; the others change it by at most
/// their own sum.
TailSum bounded(const std::vector<Mode>& modes, std::int64_t from, std::int64_t end, const Sequence& x) {
  const auto slowest = std::ranges::min_element(modes, [](const Mode& a, const Mode& b) {
    return one_minus_modulus(a.one_minus_z) < one_minus_modulus(b.one_minus_z);
  });
  if (!one_resonance({*slowest}) || !x.accurate()) return {{}, 0, x.tail(from)};
  std::vector<Mode> others(modes.begin(), slowest);
  others.insert(others.end(), slowest + 1, modes.end());
  double beside = 0;
  for (const Mode& m : others) beside += tail(m, from);
  return {resonance_sum(*slowest, from, end), beside, tail(*slowest, end)};
}

}  // namespace

RunsSum sum_of_runs(const Sequence& x, const Powers& powers, double scale, std::int64_t first,
                    std::int64_t end, std::int64_t visits) {
  SignRuns runs(x, powers, scale, visits);
  runs.cover(first, end);
  return runs.result();
}

SampledSum sampled_sum(const std::vector<Mode>& modes, const Powers& powers, std::int64_t first,
                       std::int64_t end) {
  const std::vector<Table> tables = tables_of(modes.size(), powers);
  const double rounding = 1.01 * (term_error + 0x1p-53 * static_cast<double>(modes.size()) + 0x1p-53 * block);
  SampledSum result;
  DoubleDouble total;
  std::vector<std::complex<double>> power;
  std::array<double, block> x;
  for (std::int64_t k = first; k < end; k += block) {
    powers.quick(k, power);
    x.fill(0);
    const auto count = static_cast<std::size_t>(std::min<std::int64_t>(block, end - k));
    for (std::size_t i = 0; i < modes.size(); ++i) {
      const ComplexBall& c = modes[i].c[0];
      const double twice = modes[i].pair ? 2 : 1;
      const std::complex<double> start =
          twice * std::complex<double>(c.re.mid().hi, c.im.mid().hi) * power[i];
      const double re = start.real(), im = start.imag();
      for (std::size_t j = 0; j < block; ++j) x[j] += re * tables[i].re[j] - im * tables[i].im[j];
      const double terms = std::min(static_cast<double>(count), 1 / powers.one_minus_modulus(i));
      result.error += (rounding * std::abs(start) + twice * (c.re.rad() + c.im.rad())) * terms + 1e-290;
    }
    total += DoubleDouble(absolute_sum(x, count));
  }
  result.sum = static_cast<double>(total);
  result.error = result.error * 1.001 + 0x1p-52 * result.sum;
  return result;
}

// x_k = 2 Re(c z^k) has the sign (-1)^floor(k alpha + beta), alpha = arg z/pi, beta = arg(c z^from)/pi + 1/2,
// k counted from `from`. The angles are truncated to 200 bits, and arg c is as uncertain as c: a sign can be
// wrong only where the phase is within that uncertainty of a change of sign. There |x_k| <= 2 |c z^k|
// sin(uncertainty), so that the sum is low by at most twice that over all k.
RealBall resonance_sum(const Mode& mode, std::int64_t from, std::int64_t end) {
  const FineComplex one(1.0), z = mode.z, c{fine(mode.c[0].re), fine(mode.c[0].im)};
  const FineComplex start = c * power(Word{z, {}}, static_cast<double>(from)).factor;
  const Binary256 pi = pi256();
  // The additional half cycle keeps beta positive; `sign` compensates it.
  const Binary256 alpha = atan2(z.im.mid(), z.re.mid()) / pi;
  const Binary256 beta = atan2(start.im.mid(), start.re.mid()) / pi + 1.5;
  const Integer unit = ldexp(Integer(1), fraction_bits);
  const Integer rise = fixed_point(alpha), offset = fixed_point(beta);
  const Word up{-1.0, 0.0}, on{z, z};
  const double sign = modulo(quotient(offset, unit), 2) == 0 ? -1 : 1;
  const Word all =
      line(rise, unit, modulo(offset, unit), Integer(static_cast<double>(end - from - 1)), up, on);
  const FineBall sum = FineBall(2 * sign) * (start * (one + all.share)).re;
  // The truncation grows to 2^-140 over 2^52 terms; arg(start) is off by less than twice its relative error.
  const long double size = std::hypot(start.re.largest(), start.im.largest());
  const long double uncertainty = 4 * std::max(start.re.rad(), start.im.rad()) + 0x1p-130L * size;
  const double count = std::min(static_cast<double>(end - from), 1.01 / one_minus_modulus(mode.one_minus_z));
  const DoubleDouble rounded = to_double_double(sum.mid());
  const long double error = (sum - FineBall::exactly(rounded)).largest() + 4 * uncertainty * count;
  return RealBall(rounded, static_cast<double>(error) * (1 + 0x1p-50));
}

TailSum operator+(TailSum x, const TailSum& y) {
  x.sum += y.sum;
  x.error += y.error;
  x.beyond += y.beyond;
  return x;
}

TailSum tail_sum(std::vector<Mode> modes, std::int64_t from, double scale, std::int64_t work) {
  std::vector<std::int64_t> ends;
  for (const Mode& m : modes) ends.push_back(end_of(m, from, scale));
  TailSum r;
  while (!modes.empty()) {
    const std::size_t before = modes.size();
    const Powers powers(modes);
    const Sequence x(modes, powers);
    while (modes.size() == before) {
      const std::int64_t end = *std::ranges::max_element(ends);
      std::int64_t until = end;
      if (runs_of(modes, from, end) > many_runs) {
        if (one_resonance(modes)) return r + bounded(modes, from, end, x);
        until = std::min(end, std::max(*std::ranges::min_element(ends), 2 * from));
      }
      const auto count = static_cast<std::int64_t>(modes.size());
      const double by_runs = blocks_per_run * runs_of(modes, from, until) * static_cast<double>(count);
      const double by_samples =
          static_cast<double>(until - from) / samples_per_block * static_cast<double>(count);
      const bool precise = sampling_error * x.tail(from) <= precise_sampling * scale;
      if (!x.accurate()) return r + bounded(modes, from, end, x);
      if (simple(modes) && (by_runs > static_cast<double>(work) || (precise && by_samples < by_runs))) {
        const auto most = static_cast<std::int64_t>(samples_per_block * static_cast<double>(work / count));
        const std::int64_t stop = std::min(until, from + most);
        const SampledSum s = sampled_sum(modes, powers, from, stop);
        work -= static_cast<std::int64_t>(by_samples);
        r.sum += RealBall(s.sum);
        r.error += s.error;
        from = stop;
      } else if (by_runs <= static_cast<double>(work)) {
        const RunsSum s = sum_of_runs(x, powers, scale, from, until, work / count);
        work = s.visits * count;
        r.sum += s.sum;
        r.error += s.error;
        from = s.next;
      }
      if (until == end && from == end) {
        r.beyond = x.tail(from);
        return r;
      }
      if (from < until) return r + bounded(modes, from, end, x);
      r.error += drop_decayed(modes, ends, from);
    }
  }
  return r;
}

// The changes of sign of x_{step k + offset}, over all offsets, are about max_i |arg z_i^step| end_i/pi.
std::int64_t decimation(const std::vector<Mode>& modes, std::int64_t from, double scale) {
  constexpr std::int64_t most = 240;
  // For the tables of powers, which are computed again when a mode has decayed.
  const double blocks_per_part = 2500 * static_cast<double>(modes.size() * (modes.size() + 1));
  struct Ringing {
    FineComplex z;
    double end;
  };
  std::vector<Ringing> ringing;
  for (const Mode& m : modes) ringing.push_back({m.z, static_cast<double>(end_of(m, from, scale))});
  const auto slowest =
      std::ranges::max_element(ringing, [](const Ringing& x, const Ringing& y) { return x.end < y.end; });
  if (slowest != ringing.end() && one_resonance({modes[slowest - ringing.begin()]})) {
    // Alone it is summed in closed form: its changes of sign count while there are others.
    slowest->end = 0;
    for (std::size_t i = 0; i < modes.size(); ++i) slowest->end = std::max(slowest->end, ringing[i].end);
  }
  std::vector<FineComplex> powers(ringing.size(), FineComplex(1.0));
  std::int64_t best = 1;
  double least = std::numeric_limits<double>::infinity();
  for (std::int64_t step = 1; step <= most; ++step) {
    double blocks = blocks_per_part * static_cast<double>(step), runs = 0;
    for (std::size_t i = 0; i < ringing.size(); ++i) {
      powers[i] = powers[i] * ringing[i].z;
      runs = std::max(runs, angle(powers[i]) * ringing[i].end / std::numbers::pi);
    }
    blocks += blocks_per_run * runs;
    if (blocks < least) best = step;
    least = std::min(least, blocks);
    if (least <= blocks_per_part * static_cast<double>(step + 1)) break;
  }
  return best;
}

}  // namespace qerr
