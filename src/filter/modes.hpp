#pragma once

#include <vector>

#include "complex.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// A pole in w with its multiplicity; of a conjugate pair only the upper one is listed.
struct Pole {
  WideComplex w;
  int multiplicity = 1;
  bool real() const { return w.im == Wide(0); }
  /// z = (1 + w)/(1 - w).
  WideComplex z() const { return (WideComplex(1.0) + w) / (WideComplex(1.0) - w); }
};

/// The poles of all sections; equal ones are counted together. Poles at z = 0 are those with w = -1.
std::vector<Pole> poles(const Filter&);

/// sum_m c_m C(k + m - 1, m - 1) z^k over m = 1..c.size(), plus its conjugate where `pair`: one pole's share
/// of h_k.
struct Mode {
  WideComplex z;
  WideComplex one_minus_z;  ///< kept apart: it has all its digits for a slow pole
  bool pair = false;
  std::vector<WideComplex> c;
};

/// Partial fractions of a filter: h_k is the sum of the modes for k >= from.
struct Modes {
  std::vector<Mode> modes;
  std::size_t from = 0;
  double condition = 1;  ///< by how much close poles amplify rounding
};

Modes partial_fractions(const Filter&);

}  // namespace qerr
