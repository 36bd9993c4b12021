#pragma once

#include <Eigen/Core>
#include <vector>

#include "qerr/filter/filter.hpp"

namespace qerr {

/// One filter on many channels, sample by sample, in double precision.
///
/// Every section runs as trapezoidal integrators (1/w), solved for its highest derivative: a high-pass output
/// is never the difference of two large low-pass ones, so that low cut-offs keep their digits.
class FilterBank {
 public:
  FilterBank(const Filter&, Eigen::Index channels);

  /// Replaces the inputs by the outputs. @param signals  one per channel
  /// As if x had always been the input: no transient of a constant remains.
  void settle(Eigen::ArrayXd x);

  void step(Eigen::ArrayXd& signals);

 private:
  struct Stage {
    bool second = false;
    double b0 = 0, b1 = 0, b2 = 0, a0 = 0, a01 = 0, inverse = 0;
    Eigen::ArrayXd s1, s2;
  };
  std::vector<Stage> stages_;
  std::vector<double> taps_;
  Eigen::ArrayXXd past_;  // channels x taps
  Eigen::Index next_ = 0;
  double gain_ = 1;
  Eigen::ArrayXd high_, band_;
};

}  // namespace qerr
