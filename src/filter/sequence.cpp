#include "sequence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace qerr {
namespace {

constexpr int bits = 52;
// |z| and its powers are rounded; bounds are enlarged by this much, which covers k up to 2^52.
constexpr double slack = 1.001;

std::complex<double> rounded(WideComplex x) { return {static_cast<double>(x.re), static_cast<double>(x.im)}; }

/// C(k + m - 1, m - 1) for the next m, from the one before.
double next_binomial(double binomial, std::int64_t k, std::size_t m) {
  return binomial * static_cast<double>(k + static_cast<std::int64_t>(m)) / static_cast<double>(m);
}

}  // namespace

Powers::Powers(const std::vector<Mode>& modes) {
  for (const Mode& mode : modes) {
    std::vector<WideComplex> table{mode.z};
    for (int i = 1; i < bits; ++i) table.push_back(table.back() * table.back());
    std::vector<std::complex<double>> quick;
    for (const WideComplex& z : table) quick.push_back(rounded(z));
    wide_.push_back(std::move(table));
    quick_.push_back(std::move(quick));
    // 1 - |z|^2 without cancellation: 2 Re(1 - z) - |1 - z|^2.
    const Wide gap = Wide(2) * mode.one_minus_z.re - norm(mode.one_minus_z);
    decay_.push_back(-0.5 * std::log1p(-static_cast<double>(gap)) * (1 - 1e-14));
  }
}

WideComplex Powers::wide(std::size_t mode, std::int64_t k) const {
  WideComplex r(1.0);
  for (std::size_t i = 0; k > 0; ++i, k >>= 1) {
    if ((k & 1) != 0) r = r * wide_[mode][i];
  }
  return r;
}

std::complex<double> Powers::quick(std::size_t mode, std::int64_t k) const {
  double re = 1, im = 0;
  for (std::size_t i = 0; k > 0; ++i, k >>= 1) {
    if ((k & 1) == 0) continue;
    const double x = quick_[mode][i].real(), y = quick_[mode][i].imag();
    const double turned = re * x - im * y;
    im = re * y + im * x;
    re = turned;
  }
  return {re, im};
}

double Powers::modulus(std::size_t mode, std::int64_t k) const {
  return std::exp(-decay_[mode] * static_cast<double>(k));
}

double Powers::one_minus_modulus(std::size_t mode) const { return -std::expm1(-decay_[mode]); }

Wide Sequence::at(std::int64_t k) const {
  Wide total;
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    const Mode& mode = modes_[i];
    WideComplex sum;
    Wide binomial = 1.0;
    for (std::size_t m = 1; m <= mode.c.size(); ++m) {
      sum = sum + mode.c[m - 1] * WideComplex(binomial);
      binomial = binomial * Wide(static_cast<double>(k + static_cast<std::int64_t>(m))) /
                 Wide(static_cast<double>(m));
    }
    const Wide share = (sum * powers_->wide(i, k)).re;
    total += mode.pair ? share + share : share;
  }
  return total;
}

double Sequence::quick_at(std::int64_t k) const {
  double total = 0;
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    const Mode& mode = modes_[i];
    double re = 0, im = 0, binomial = 1;
    for (std::size_t m = 1; m <= mode.c.size(); ++m) {
      re += mode.c[m - 1].re.hi * binomial;
      im += mode.c[m - 1].im.hi * binomial;
      binomial = next_binomial(binomial, k, m);
    }
    const std::complex<double> power = powers_->quick(i, k);
    total += (mode.pair ? 2 : 1) * (re * power.real() - im * power.imag());
  }
  return total;
}

double Sequence::bound(std::int64_t first, std::int64_t last) const {
  double total = 0;
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    const Mode& mode = modes_[i];
    double sum = 0, binomial = 1;
    for (std::size_t m = 1; m <= mode.c.size(); ++m) {
      sum += magnitude(mode.c[m - 1]) * binomial;
      binomial = next_binomial(binomial, last, m);
    }
    total += (mode.pair ? 2 : 1) * sum * powers_->modulus(i, first);
  }
  return total * slack;
}

double Sequence::tail(std::int64_t first) const {
  double total = 0;
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    const Mode& mode = modes_[i];
    double sum = 0, binomial = 1;
    const double modulus = powers_->modulus(i, 1);
    for (std::size_t m = 1; m <= mode.c.size(); ++m) {
      // Terms fall at least as fast as this ratio from `first` on: a geometric series.
      const double growth = static_cast<double>(m - 1) / static_cast<double>(first + 1);
      const double gap = powers_->one_minus_modulus(i) - growth * modulus;
      if (!(gap > 0)) return std::numeric_limits<double>::infinity();
      sum += magnitude(mode.c[m - 1]) * binomial / gap;
      binomial = next_binomial(binomial, first, m);
    }
    total += (mode.pair ? 2 : 1) * sum * powers_->modulus(i, first);
  }
  return total * slack;
}

Sequence Sequence::difference() const {
  Sequence result = *this;  // 1 - q = ((1 - z q) - (1 - z))/z
  for (Mode& mode : result.modes_) {
    for (std::size_t m = 0; m < mode.c.size(); ++m) {
      const WideComplex above = m + 1 < mode.c.size() ? mode.c[m + 1] : WideComplex();
      mode.c[m] = (above - mode.one_minus_z * mode.c[m]) / mode.z;
    }
  }
  return result;
}

Sequence Sequence::transient_of_sum() const {
  Sequence result = *this;  // 1/((1-q)(1-zq)^m) = [1/((1-q)(1-zq)^(m-1)) - z/(1-zq)^m]/(1-z)
  for (Mode& mode : result.modes_) {
    WideComplex carry;
    for (std::size_t m = mode.c.size(); m-- > 0;) {
      carry = (mode.c[m] + carry) / mode.one_minus_z;
      mode.c[m] = -(mode.z * carry);
    }
  }
  return result;
}

}  // namespace qerr
