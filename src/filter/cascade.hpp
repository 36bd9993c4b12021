#pragma once

#include <vector>

#include "double_double.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// Runs a filter sample by sample in double-double, every section as trapezoidal integrators.
///
/// 1/w is the trapezoidal integrator, so a section is solved for its highest derivative w^2 u (or w u) and
/// the rest are integrals of it: a high-pass output is never the difference of two large low-pass ones.
class Cascade {
 public:
  explicit Cascade(const Filter& filter);
  Wide step(Wide input);

 private:
  struct Stage {
    bool second = false;
    Wide b0, b1, b2, a0, a01, inverse;
    Wide s1, s2;
    Wide step(Wide x);
  };
  std::vector<Stage> stages_;
  std::vector<double> taps_;
  std::vector<Wide> past_;
  std::size_t next_ = 0;
  Wide gain_;
};

}  // namespace qerr
