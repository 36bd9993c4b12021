#include "roots_in_w.hpp"

#include <algorithm>
#include <array>

namespace qerr {
namespace {

using Polynomial = std::array<Wide, 3>;

const LinearFactor one{1.0, 0.0};

Polynomial times(const LinearFactor& x, const LinearFactor& y) {
  return {(x.u * y.u).re, (x.u * y.v + x.v * y.u).re, (x.v * y.v).re};
}

Polynomial pair(const LinearFactor& x) { return times(x, {conj(x.u), conj(x.v)}); }

/// Divides by the lowest coefficient that is not 0 and hands it over.
Polynomial monic(Polynomial p, Wide& lead) {
  lead = p[0].hi != 0 ? p[0] : p[1].hi != 0 ? p[1] : p[2];
  for (Wide& c : p) c = c / lead;
  return p;
}

/// Takes the last factor, the one of the slowest root, or 1 when there is none.
LinearFactor take(std::vector<LinearFactor>& list) {
  if (list.empty()) return one;
  const LinearFactor last = list.back();
  list.pop_back();
  return last;
}

struct Split {
  std::vector<LinearFactor> real, complex;
};

/// By kind, fast roots first.
Split split(const std::vector<LinearFactor>& factors) {
  Split s;
  for (const LinearFactor& f : factors) (f.real() ? s.real : s.complex).push_back(f);
  const auto faster = [](const LinearFactor& x, const LinearFactor& y) {
    return magnitude(x.u) * magnitude(y.v) > magnitude(y.u) * magnitude(x.v);
  };
  std::stable_sort(s.real.begin(), s.real.end(), faster);
  std::stable_sort(s.complex.begin(), s.complex.end(), faster);
  return s;
}

}  // namespace

Filter filter_from_factors(Wide gain, std::vector<LinearFactor> above, std::vector<LinearFactor> below,
                           double sample_rate, int derivative) {
  Filter filter{{}, gain, sample_rate, derivative};
  Split zeros = split(above), poles = split(below);
  const auto add = [&](const Polynomial& b, const Polynomial& a) {
    Wide over, under;
    filter.sections.push_back({monic(b, over), monic(a, under)});
    filter.gain = filter.gain * (over / under);
  };
  while (!poles.complex.empty()) {
    const Polynomial a = pair(take(poles.complex));
    if (!zeros.complex.empty()) {
      add(pair(take(zeros.complex)), a);
    } else {
      const LinearFactor first = take(zeros.real), second = take(zeros.real);
      add(times(first, second), a);
    }
  }
  while (!zeros.complex.empty()) {
    const LinearFactor first = take(poles.real), second = take(poles.real);
    add(pair(take(zeros.complex)), times(first, second));
  }
  while (!poles.real.empty()) add(times(take(zeros.real), one), times(take(poles.real), one));
  if (filter.sections.empty()) filter.taps = {1};
  return filter;
}

}  // namespace qerr
