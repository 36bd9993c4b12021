#include "filter/norms/sampled_sum.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace qerr {
namespace {

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
constexpr double sum_error = 2 * parts * 0x1p-53;

double absolute_sum(const std::array<double, block>& x, std::size_t count) {
  double sum = 0;
  for (std::size_t start = 0; start < count; start += block / parts) {
    double part = 0;
    for (std::size_t j = start; j < std::min(count, start + block / parts); ++j) part += std::abs(x[j]);
    sum += part;
  }
  return sum;
}

}  // namespace

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

}  // namespace qerr
