#pragma once

#include <Eigen/Core>
#include <vector>

#include "qerr/filter/filter.hpp"

namespace qerr::testing {

/// One filter on many channels, sample by sample, written plainly: the reference of the recursions in
/// src/filter/run. Every section runs as trapezoidal integrators 1/w, solved for its highest derivative.
class ReferenceFilter {
 public:
  ReferenceFilter(const Filter& filter, Eigen::Index channels) : gain_(filter.gain) {
    for (const DoubleDouble& tap : filter.taps) taps_.push_back(static_cast<double>(tap));
    for (const Section& s : filter.sections) {
      Stage& stage = stages_.emplace_back();
      const auto plain = [](auto c) { return static_cast<double>(c); };
      stage.second = plain(s.a[2]) != 0;
      stage.b0 = plain(s.b[0]), stage.b1 = plain(s.b[1]), stage.b2 = plain(s.b[2]);
      stage.a0 = plain(s.a[0]);
      stage.a01 = plain(s.a[0]) + plain(s.a[1]);
      stage.inverse = 1 / (stage.a01 + plain(s.a[2]));
      stage.s1 = stage.s2 = Eigen::ArrayXd::Zero(channels);
    }
    if (!taps_.empty()) past_ = Eigen::ArrayXXd::Zero(channels, static_cast<Eigen::Index>(taps_.size()));
  }

  /// To the steady state for the constant input x.
  void settle(Eigen::ArrayXd x) {
    x *= gain_;
    for (Stage& s : stages_) {
      // The high-pass output is 0, and a0 times the low-pass state is the input.
      Eigen::ArrayXd& low = s.second ? s.s2 : s.s1;
      if (s.second) s.s1.setZero();
      low = x / s.a0;
      x = s.b0 * low;
    }
    for (Eigen::Index i = 0; i < past_.cols(); ++i) past_.col(i) = x;
  }

  /// Replaces the inputs, one per channel, by the outputs.
  void step(Eigen::ArrayXd& x) {
    x *= gain_;
    for (Stage& s : stages_) {
      const Eigen::ArrayXd high = s.second ? Eigen::ArrayXd((x - s.a01 * s.s1 - s.a0 * s.s2) * s.inverse)
                                           : Eigen::ArrayXd((x - s.a0 * s.s1) * s.inverse);
      const Eigen::ArrayXd band = high + s.s1;
      if (s.second) {
        const Eigen::ArrayXd low = band + s.s2;
        x = s.b0 * low + s.b1 * band + s.b2 * high;
        s.s2 = low + band;
      } else {
        x = s.b0 * band + s.b1 * high;
      }
      s.s1 = band + high;
    }
    if (taps_.empty()) return;
    for (Eigen::Index i = past_.cols() - 1; i > 0; --i) past_.col(i) = past_.col(i - 1).eval();
    past_.col(0) = x;
    x.setZero();
    for (std::size_t k = 0; k < taps_.size(); ++k) x += taps_[k] * past_.col(static_cast<Eigen::Index>(k));
  }

 private:
  struct Stage {
    bool second = false;
    double b0 = 0, b1 = 0, b2 = 0, a0 = 0, a01 = 0, inverse = 0;
    Eigen::ArrayXd s1, s2;
  };
  std::vector<Stage> stages_;
  std::vector<double> taps_;
  Eigen::ArrayXXd past_;  // channels x taps, the newest first
  double gain_ = 1;
};

}  // namespace qerr::testing
