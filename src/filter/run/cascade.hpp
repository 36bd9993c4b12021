#pragma once

#include <vector>

#include "qerr/core/double_double.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// Runs a filter sample by sample, every section as trapezoidal integrators.
///
/// 1/w is the trapezoidal integrator, so a section is solved for its highest derivative w^2 u (or w u) and
/// the rest are integrals of it: a high-pass output is never the difference of two large low-pass ones.
template <class Scalar>
class BasicCascade {
 public:
  explicit BasicCascade(const Filter& filter);
  Scalar step(Scalar input);

 private:
  struct Stage {
    bool second = false;
    Scalar b0{}, b1{}, b2{}, a0{}, a01{}, inverse{};
    Scalar s1{}, s2{};
    Scalar step(Scalar x);
  };
  std::vector<Stage> stages_;
  std::vector<double> taps_;
  std::vector<Scalar> past_;
  std::size_t next_ = 0;
  Scalar gain_{};
};

extern template class BasicCascade<double>;
extern template class BasicCascade<DoubleDouble>;

/// In double-double, for what is asserted to the last digit.
using Cascade = BasicCascade<DoubleDouble>;

}  // namespace qerr
