#include "sequence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace qerr {
namespace {

constexpr int bits = 52;
// A bound in doubles takes a few hundred operations, each off by 2^-53; this is far more. The other part
// keeps a bound above 0 where the powers vanish.
constexpr double slack = 1.001;
constexpr double least = 1e-290;

std::complex<double> rounded(const SureComplex& x) { return {x.re.mid().hi, x.im.mid().hi}; }

/// C(k + m - 1, m - 1) for the next m, from the one before.
double next_binomial(double binomial, std::int64_t k, std::size_t m) {
  return binomial * static_cast<double>(k + static_cast<std::int64_t>(m)) / static_cast<double>(m);
}

}  // namespace

Powers::Powers(const std::vector<Mode>& modes) {
  for (const Mode& mode : modes) {
    std::vector<SureComplex> table{mode.z};
    for (int i = 1; i < bits; ++i) table.push_back(table.back() * table.back());
    std::vector<std::complex<double>> quick;
    for (const SureComplex& z : table) quick.push_back(rounded(z));
    sure_.push_back(std::move(table));
    quick_.push_back(std::move(quick));
    // 1 - |z|^2 without cancellation: 2 Re(1 - z) - |1 - z|^2.
    const Sure gap = Sure(2.0) * mode.one_minus_z.re - norm(mode.one_minus_z);
    // At most 1000, so that a pole next to z = 0 has a finite one.
    decay_.push_back(std::min(-0.5 * std::log1p(-gap.smallest()) * (1 - 1e-14), 1000.0));
  }
}

SureComplex Powers::sure(std::size_t mode, std::int64_t k) const {
  SureComplex r(1.0);
  for (std::size_t i = 0; k > 0; ++i, k >>= 1) {
    if ((k & 1) != 0) r = r * sure_[mode][i];
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

Sure Sequence::at(std::int64_t k) const {
  Sure total;
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    const Mode& mode = modes_[i];
    SureComplex sum;
    Sure binomial(1.0);
    for (std::size_t m = 1; m <= mode.c.size(); ++m) {
      sum = sum + mode.c[m - 1] * SureComplex(binomial);
      binomial = binomial * Sure(static_cast<double>(k + static_cast<std::int64_t>(m))) /
                 Sure(static_cast<double>(m));
    }
    const Sure share = (sum * powers_->sure(i, k)).re;
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
      re += mode.c[m - 1].re.mid().hi * binomial;
      im += mode.c[m - 1].im.mid().hi * binomial;
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
      sum += largest(mode.c[m - 1]) * binomial;
      binomial = next_binomial(binomial, last, m);
    }
    total += (mode.pair ? 2 : 1) * sum * powers_->modulus(i, first);
  }
  return total * slack + least;
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
      sum += largest(mode.c[m - 1]) * binomial / gap;
      binomial = next_binomial(binomial, first, m);
    }
    total += (mode.pair ? 2 : 1) * sum * powers_->modulus(i, first);
  }
  return total * slack + least;
}

bool Sequence::trusted() const {
  for (const Mode& mode : modes_) {
    double size = 0;  // the binomials grow with m, so a coefficient may hide behind the larger ones above it
    for (std::size_t m = mode.c.size(); m-- > 0;) {
      const SureComplex& c = mode.c[m];
      size = std::max(size, std::hypot(c.re.mid().hi, c.im.mid().hi));
      if (!(std::max(c.re.rad(), c.im.rad()) <= 1e-14 * size)) return false;
    }
  }
  return true;
}

Sequence Sequence::difference() const {
  Sequence result = *this;  // 1 - q = ((1 - z q) - (1 - z))/z
  for (Mode& mode : result.modes_) {
    for (std::size_t m = 0; m < mode.c.size(); ++m) {
      const SureComplex above = m + 1 < mode.c.size() ? mode.c[m + 1] : SureComplex();
      mode.c[m] = (above - mode.one_minus_z * mode.c[m]) / mode.z;
    }
  }
  return result;
}

Sequence Sequence::transient_of_sum() const {
  Sequence result = *this;  // 1/((1-q)(1-zq)^m) = [1/((1-q)(1-zq)^(m-1)) - z/(1-zq)^m]/(1-z)
  for (Mode& mode : result.modes_) {
    SureComplex carry;
    for (std::size_t m = mode.c.size(); m-- > 0;) {
      carry = (mode.c[m] + carry) / mode.one_minus_z;
      mode.c[m] = -(mode.z * carry);
    }
  }
  return result;
}

}  // namespace qerr
