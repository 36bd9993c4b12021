#include "filter/run/filter_bank.hpp"

namespace qerr {

FilterBank::FilterBank(const Filter& filter, Eigen::Index channels)
    : taps_(filter.taps), gain_(filter.gain), high_(channels), band_(channels) {
  for (const Section& s : filter.sections) {
    Stage& stage = stages_.emplace_back();
    const auto plain = [](auto c) { return static_cast<double>(c); };
    stage.second = plain(s.a[2]) != 0;
    stage.b0 = plain(s.b[0]);
    stage.b1 = plain(s.b[1]);
    stage.b2 = plain(s.b[2]);
    stage.a0 = plain(s.a[0]);
    stage.a01 = plain(s.a[0]) + plain(s.a[1]);
    stage.inverse = 1 / (stage.a01 + plain(s.a[2]));
    stage.s1 = Eigen::ArrayXd::Zero(channels);
    stage.s2 = Eigen::ArrayXd::Zero(stage.second ? channels : 0);
  }
  if (!taps_.empty()) past_ = Eigen::ArrayXXd::Zero(channels, static_cast<Eigen::Index>(taps_.size()));
}

void FilterBank::settle(Eigen::ArrayXd x) {
  x *= gain_;
  for (Stage& s : stages_) {
    // Nothing changes: the high-pass output is 0, and a0 times the low-pass state is the input.
    Eigen::ArrayXd& low = s.second ? s.s2 : s.s1;
    if (s.second) s.s1.setZero();
    low = x / s.a0;
    x = s.b0 * low;
  }
  for (Eigen::Index i = 0; i < past_.cols(); ++i) past_.col(i) = x;
}

void FilterBank::step(Eigen::ArrayXd& x) {
  x *= gain_;
  for (Stage& s : stages_) {
    if (!s.second) {
      high_ = (x - s.a0 * s.s1) * s.inverse;
      s.s1 += high_;  // the low-pass output
      x = s.b0 * s.s1 + s.b1 * high_;
      s.s1 += high_;
      continue;
    }
    high_ = (x - s.a01 * s.s1 - s.a0 * s.s2) * s.inverse;
    band_ = high_ + s.s1;
    s.s2 += band_;  // the low-pass output
    x = s.b0 * s.s2 + s.b1 * band_ + s.b2 * high_;
    s.s1 = band_ + high_;
    s.s2 += band_;
  }
  if (taps_.empty()) return;
  past_.col(next_) = x;
  x.setZero();
  Eigen::Index at = next_;
  for (const double tap : taps_) {
    x += tap * past_.col(at);
    at = (at == 0 ? past_.cols() : at) - 1;
  }
  next_ = (next_ + 1) % past_.cols();
}

}  // namespace qerr
