#include "filter/norms/sequence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace qerr {
namespace {

constexpr int bits = 60;  // of latest_sample, in whole digits
constexpr int taylor_order = 12;
constexpr std::size_t base = 16;  // of the digits in the table of quick powers
// A bound in doubles takes a few hundred operations with relative errors of 2^-53, much less than `slack`.
// `least` keeps a bound above 0 where the powers underflow.
constexpr double slack = 1.001;
constexpr double least = 1e-290;

using Quick = std::complex<double>;

/// x y, without the treatment of infinities by std::complex.
Quick times(const Quick& x, const Quick& y) {
  return {x.real() * y.real() - x.imag() * y.imag(), x.real() * y.imag() + x.imag() * y.real()};
}

Quick rounded(const ComplexBall& x) { return {x.re.mid().hi, x.im.mid().hi}; }

/// An integer of up to 106 bits.
RealBall exact_ball(std::int64_t k) {
  const auto high = static_cast<double>(k);
  return RealBall(DoubleDouble(high, static_cast<double>(k - static_cast<std::int64_t>(high))));
}

/// C(k + m, m) from C(k + m - 1, m - 1).
double next_binomial(double binomial, std::int64_t k, std::size_t m) {
  return binomial * static_cast<double>(k + static_cast<std::int64_t>(m)) / static_cast<double>(m);
}

}  // namespace

Decays::Decays(const std::vector<Mode>& modes) {
  for (const Mode& mode : modes) {
    // 1 - |z|^2 without cancellation: 2 Re(1 - z) - |1 - z|^2.
    const RealBall gap = RealBall(2.0) * mode.one_minus_z.re - norm(mode.one_minus_z);
    // At most 1000: finite for a pole close to z = 0.
    decay_.push_back(std::min(-0.5 * std::log1p(-gap.smallest()) * (1 - 1e-14), 1000.0));
  }
}

void Decays::moduli(std::int64_t k, std::vector<double>& moduli) const {
  moduli.resize(decay_.size());
  for (std::size_t i = 0; i < moduli.size(); ++i) moduli[i] = modulus(i, k);
}

double Decays::modulus(std::size_t mode, std::int64_t k) const {
  return std::exp(-decay_[mode] * static_cast<double>(k));
}

double Decays::one_minus_modulus(std::size_t mode) const { return -std::expm1(-decay_[mode]); }

double tail(const Mode& mode, std::int64_t first) {
  const Decays decays({mode});
  double sum = 0, binomial = 1;
  const double modulus = decays.modulus(0, 1);
  for (std::size_t m = 1; m <= mode.c.size(); ++m) {
    // From `first` on the terms decrease at least as a geometric series of ratio 1 - gap.
    const double growth = static_cast<double>(m - 1) / static_cast<double>(first + 1);
    const double gap = decays.one_minus_modulus(0) - growth * modulus;
    if (!(gap > 0)) return std::numeric_limits<double>::infinity();
    sum += largest(mode.c[m - 1]) * binomial / gap;
    binomial = next_binomial(binomial, first, m);
  }
  return (mode.pair ? 2 : 1) * sum * decays.modulus(0, first) * slack + least;
}

Powers::Powers(const std::vector<Mode>& modes) : Decays(modes) {
  for (const Mode& mode : modes) {
    std::vector<ComplexBall> table;
    std::vector<Quick> quick;
    FineComplex digit = mode.z;  // z^(16^i)
    for (int i = 0; i < bits; i += 4) {
      const ComplexBall factor = rounded(digit);
      table.emplace_back(1.0);
      for (std::size_t j = 1; j < base; ++j) table.push_back(table.back() * factor);
      digit = power(digit, base);
    }
    for (const ComplexBall& power : table) quick.push_back(rounded(power));
    proven_.push_back(std::move(table));
    quick_.push_back(std::move(quick));
  }
}

std::vector<ComplexBall> Powers::proven(std::int64_t k) const {
  std::vector<ComplexBall> powers(proven_.size(), ComplexBall(1.0));
  for (std::size_t row = 0; k > 0; row += base, k /= static_cast<std::int64_t>(base)) {
    const std::size_t digit = row + static_cast<std::size_t>(k) % base;
    if (digit == row) continue;
    for (std::size_t i = 0; i < powers.size(); ++i) powers[i] = powers[i] * proven_[i][digit];
  }
  return powers;
}

void Powers::quick(std::int64_t k, std::vector<Quick>& powers) const {
  powers.assign(quick_.size(), 1.0);
  for (std::size_t row = 0; k > 0; row += base, k /= static_cast<std::int64_t>(base)) {
    const std::size_t digit = row + static_cast<std::size_t>(k) % base;
    if (digit == row) continue;
    for (std::size_t i = 0; i < powers.size(); ++i) powers[i] = times(powers[i], quick_[i][digit]);
  }
}

Sequence::Sequence(std::vector<Mode> modes, const Powers& powers)
    : modes_(std::move(modes)), powers_(&powers) {
  for (const Mode& mode : modes_) {
    const double count = mode.pair ? 2 : 1;
    std::vector<Coefficient> row;
    for (const ComplexBall& c : mode.c)
      row.push_back({count * c.re.mid().hi, count * c.im.mid().hi, count * largest(c)});
    rounded_.push_back(std::move(row));
  }
}

RealBall Sequence::at(std::int64_t k, const std::vector<ComplexBall>& powers) const {
  RealBall total;
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    const Mode& mode = modes_[i];
    ComplexBall sum = mode.c[0];
    RealBall binomial(1.0);
    for (std::size_t m = 1; m < mode.c.size(); ++m) {
      binomial = binomial * exact_ball(k + static_cast<std::int64_t>(m)) / RealBall(static_cast<double>(m));
      sum = sum + mode.c[m] * ComplexBall(binomial);
    }
    const RealBall share = sum.re * powers[i].re - sum.im * powers[i].im;
    total += mode.pair ? share + share : share;
  }
  return total;
}

double Sequence::quick_at(std::int64_t k, const std::vector<Quick>& powers) const {
  double total = 0;
  for (std::size_t i = 0; i < rounded_.size(); ++i) {
    double re = 0, im = 0, binomial = 1;
    for (std::size_t m = 1; m <= rounded_[i].size(); ++m) {
      re += rounded_[i][m - 1].re * binomial;
      im += rounded_[i][m - 1].im * binomial;
      if (m < rounded_[i].size()) binomial = next_binomial(binomial, k, m);
    }
    total += re * powers[i].real() - im * powers[i].imag();
  }
  return total;
}

double Sequence::bound(std::int64_t first, std::int64_t last) const {
  std::vector<double> moduli;
  powers_->moduli(first, moduli);
  return bound(moduli, last);
}

double Sequence::bound(const std::vector<double>& moduli, std::int64_t last) const {
  double total = 0;
  for (std::size_t i = 0; i < rounded_.size(); ++i) {
    double sum = 0, binomial = 1;
    for (std::size_t m = 1; m <= rounded_[i].size(); ++m) {
      sum += rounded_[i][m - 1].size * binomial;
      if (m < rounded_[i].size()) binomial = next_binomial(binomial, last, m);
    }
    total += sum * moduli[i];
  }
  return total * slack + least;
}

double Sequence::tail(std::int64_t first) const {
  double total = 0;
  for (const Mode& mode : modes_) total += qerr::tail(mode, first);
  return total;
}

bool Sequence::accurate() const {
  for (const Mode& mode : modes_) {
    double size = 0;  // the binomials grow with m: relative to the largest coefficient of this or a higher m
    for (std::size_t m = mode.c.size(); m-- > 0;) {
      const ComplexBall& c = mode.c[m];
      size = std::max(size, std::hypot(c.re.mid().hi, c.im.mid().hi));
      if (!(std::max(c.re.rad(), c.im.rad()) <= 1e-14 * size)) return false;
    }
  }
  return true;
}

double Sequence::mean_multiplicity() const {
  std::size_t terms = 0;
  for (const Mode& mode : modes_) terms += mode.c.size();
  return static_cast<double>(terms) / static_cast<double>(modes_.size());
}

Sequence Sequence::difference() const {
  std::vector<Mode> result = modes_;  // 1 - q = ((1 - z q) - (1 - z))/z
  for (Mode& mode : result) {
    for (std::size_t m = 0; m < mode.c.size(); ++m) {
      const ComplexBall above = m + 1 < mode.c.size() ? mode.c[m + 1] : ComplexBall();
      mode.c[m] = (above - mode.one_minus_z * mode.c[m]) / rounded(mode.z);
    }
  }
  return {std::move(result), *powers_};
}

Sequence Sequence::transient_of_sum() const {
  std::vector<Mode> result = modes_;  // 1/((1-q)(1-zq)^m) = [1/((1-q)(1-zq)^(m-1)) - z/(1-zq)^m]/(1-z)
  for (Mode& mode : result) {
    ComplexBall carry;
    for (std::size_t m = mode.c.size(); m-- > 0;) {
      carry = (mode.c[m] + carry) / mode.one_minus_z;
      mode.c[m] = -(rounded(mode.z) * carry);
    }
  }
  return {std::move(result), *powers_};
}

Sequence Sequence::plus(double factor, const Sequence& other) const {
  std::vector<Mode> result = modes_;
  for (std::size_t i = 0; i < result.size(); ++i)
    for (std::size_t m = 0; m < result[i].c.size(); ++m)
      result[i].c[m] = result[i].c[m] + ComplexBall(factor) * other.modes_[i].c[m];
  return {std::move(result), *powers_};
}

Differences::Differences(const Sequence& x) : list_{x} {
  for (int j = 0; j < taylor_order; ++j) list_.push_back(list_.back().difference());
}

double Differences::variation(std::int64_t first, std::int64_t end, std::int64_t middle,
                              const std::vector<ComplexBall>& powers) const {
  const double radius = static_cast<double>(std::max(middle - first, end - 1 - middle));
  double change = 0, weight = 1;
  for (int j = 1; j <= taylor_order; ++j) {
    weight *= (radius + j - 1) / j;  // C(radius + j - 1, j), the largest weight on either side
    const Sequence& d = list_[j];
    change += 1.001 * weight * (j < taylor_order ? d.at(middle, powers).largest() : d.bound(first, end - 1));
  }
  return change;
}

}  // namespace qerr
