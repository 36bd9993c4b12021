#include <algorithm>
#include <array>

#include "filter/design/representations/representations.hpp"
#include "filter/norms/numerical_error.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {
namespace {

using Polynomial = std::array<Binary1024, 3>;

constexpr double negligible = 1e-13;  // deviation relative to the H2 norm

const LinearFactor one{1.0, 0.0};

Polynomial product(const LinearFactor& x, const LinearFactor& y) {
  return {(x.u * y.u).re, (x.u * y.v + x.v * y.u).re, (x.v * y.v).re};
}

Polynomial pair(const LinearFactor& x) { return product(x, {conj(x.u), conj(x.v)}); }

/// Divides by the lowest coefficient that is not 0.
/// @param lead  set to it
std::array<DoubleDouble, 3> monic(const Polynomial& p, Binary1024& lead) {
  lead = p[0] != 0 ? p[0] : p[1] != 0 ? p[1] : p[2];
  return {to_double_double(p[0] / lead), to_double_double(p[1] / lead), to_double_double(p[2] / lead)};
}

/// Removes the last factor, the one of the slowest root; the factor 1 if the list is empty.
LinearFactor remove_slowest(std::vector<LinearFactor>& list) {
  if (list.empty()) return one;
  const LinearFactor last = list.back();
  list.pop_back();
  return last;
}

struct Split {
  std::vector<LinearFactor> real, complex;
};

/// Real and complex factors, each with fast roots first.
Split split(const std::vector<LinearFactor>& factors) {
  Split s;
  for (const LinearFactor& f : factors) (f.real() ? s.real : s.complex).push_back(f);
  const auto faster = [](const LinearFactor& x, const LinearFactor& y) {
    return magnitude(x.u) * magnitude(y.v) > magnitude(y.u) * magnitude(x.v);
  };
  std::ranges::stable_sort(s.real, faster);
  std::ranges::stable_sort(s.complex, faster);
  return s;
}

}  // namespace

Filter filter_from_factors(const Binary1024& gain, const std::vector<LinearFactor>& above,
                           const std::vector<LinearFactor>& below, double sample_rate, int derivative) {
  Filter filter{{}, 1, sample_rate, derivative};
  Binary1024 whole = gain;
  Split zeros = split(above), poles = split(below);
  const auto add = [&](const Polynomial& b, const Polynomial& a) {
    Binary1024 over, under;
    filter.sections.push_back({monic(b, over), monic(a, under)});
    whole *= over / under;
  };
  while (!poles.complex.empty()) {
    const Polynomial a = pair(remove_slowest(poles.complex));
    if (!zeros.complex.empty()) {
      add(pair(remove_slowest(zeros.complex)), a);
    } else {
      const LinearFactor first = remove_slowest(zeros.real), second = remove_slowest(zeros.real);
      add(product(first, second), a);
    }
  }
  while (!zeros.complex.empty()) {
    const LinearFactor first = remove_slowest(poles.real), second = remove_slowest(poles.real);
    add(pair(remove_slowest(zeros.complex)), product(first, second));
  }
  while (!poles.real.empty())
    add(product(remove_slowest(zeros.real), one), product(remove_slowest(poles.real), one));
  if (filter.sections.empty()) filter.taps = {1};
  filter.gain = to_double_double(whole);
  return filter;
}

std::vector<Binary1024> times(const std::vector<Binary1024>& x, const std::vector<Binary1024>& y) {
  std::vector<Binary1024> r(x.size() + y.size() - 1);
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t j = 0; j < y.size(); ++j) r[i + j] += x[i] * y[j];
  }
  return r;
}

bool set_deviation(Filter& filter, const std::vector<Binary1024>& b, const std::vector<Binary1024>& a,
                   double largest_modulus, const std::string& key) {
  if (!filter.taps.empty()) return true;
  const auto deviation = deviation_of(filter, b, a, largest_modulus);
  if (!deviation) throw unstable(key, largest_modulus);
  filter.deviation = *deviation;
  return deviation->h2 <= negligible * h2_norm(filter);
}

}  // namespace qerr
