#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/random.hpp"
#include "diagnose/surrogates/surrogate.hpp"

/// Surrogates row by row without vector kernels, as defined in surrogate.hpp.
namespace qerr::testing {

class ReferenceSurrogates {
 public:
  ReferenceSurrogates(const Evidence& e, std::uint64_t seed, Eigen::Index lanes)
      : e_(e),
        noise_(e.noise / e.step()),
        below_(e.encoder.rounding == Rounding::down ? 0.5 : 0.0),
        path_(straightened(e)),
        rest_(Eigen::ArrayXi::Zero(e.rows())),
        phase_(lanes) {
    const double part = kept();
    pole_ = pole_that_keeps(part);
    if (e.ordered) find_standstills(4 * noise_ * std::sqrt(part));
    for (Eigen::ArrayXd* a : {&first_, &second_, &drawn_, &level_, &x_}) *a = Eigen::ArrayXd::Zero(lanes);
    for (Eigen::Index i = 0; i < lanes; ++i) {
      const auto number = static_cast<std::uint64_t>(i);
      state_.push_back(random_bits(seed, number, 0x6e6f697365));
      phase_[i] = e.encoder.zero_known ? 0 : unit_interval(random_bits(seed, number, 0x7068617365)) - 0.5;
    }
  }

  void start() {
    first_.setZero();
    second_.setZero();
    resting_ = 0;
    for (double left = 1; left > 1e-2; left *= std::max(pole_, 1e-3)) draw();
  }

  void read(Eigen::Index row, Eigen::ArrayXd& residual, Eigen::ArrayXi& state) {
    draw();
    if (rest_[row] > 0 && (resting_ == 0 || path_[row] != path_[row - 1]))
      level_ = noise_ / std::sqrt(static_cast<double>(rest_[row])) * drawn_;
    resting_ = rest_[row];
    x_ = resting_ > 0 ? level_ : second_;
    if (e_.random_sigma.size() > 0) {
      draw_numbers();
      x_ += e_.random_sigma[row] / e_.step() * drawn_;
    }
    const double whole = std::floor(path_[row]);
    x_ += (path_[row] - whole - below_) + phase_;
    // Adding and subtracting 1.5 * 2^52 rounds to nearest, ties to even.
    residual = (x_ + 6755399441055744.0) - 6755399441055744.0;
    const int whole_state = static_cast<int>(std::fmod(whole, 4.0)) + 4;
    for (Eigen::Index i = 0; i < x_.size(); ++i) state[i] = (whole_state + static_cast<int>(residual[i])) & 3;
    residual -= phase_ + (e_.reference[row] / e_.step() - whole);
  }

 private:
  static Eigen::ArrayXd slow_part(Eigen::ArrayXd x) {
    for (int pass = 0; pass < 2; ++pass) {
      Eigen::ArrayXd sums(x.size() + 1);
      sums[0] = 0;
      for (Eigen::Index k = 0; k < x.size(); ++k) sums[k + 1] = sums[k] + x[k];
      for (Eigen::Index k = 0; k < x.size(); ++k) {
        const Eigen::Index half = std::min({Eigen::Index{4}, k, x.size() - 1 - k});
        x[k] = (sums[k + half + 1] - sums[k - half]) / static_cast<double>(2 * half + 1);
      }
    }
    return x;
  }

  static Eigen::ArrayXd straightened(const Evidence& e) {
    if (!e.ordered) return e.path / e.step();
    return (e.path + slow_part(e.reference - e.path)) / e.step();
  }

  double kept() const {
    if (e_.noise <= 0 || e_.rows() < 2) return 1;
    const double taken =
        (e_.reference / e_.step() - path_).square().mean() * std::pow(e_.step() / e_.noise, 2);
    return std::clamp(1 - taken, 0.03, 1.0);
  }

  static double pole_that_keeps(double part) {
    const auto kept_by = [](double a) { return (1 - a) * (1 + a * a) / std::pow(1 + a, 3); };
    double low = 0, high = 0.999;
    for (int i = 0; i < 40; ++i) (kept_by(0.5 * (low + high)) > part ? low : high) = 0.5 * (low + high);
    return 0.5 * (low + high);
  }

  void find_standstills(double tolerance) {
    for (Eigen::Index first = 0, end = 0; first < path_.size(); first = end) {
      double sum = 0;
      for (end = first; end < path_.size(); ++end) {
        if (end > first && std::abs(path_[end] - sum / static_cast<double>(end - first)) > tolerance) break;
        sum += path_[end];
      }
      if (end - first < 50) continue;
      path_.segment(first, end - first) = sum / static_cast<double>(end - first);
      rest_.segment(first, end - first) = static_cast<int>(end - first);
    }
  }

  /// Sum of four numbers of 16 bits, to mean 0 and variance 1.
  static double normal_like(std::uint64_t z) {
    double sum = 0;
    for (int part = 0; part < 4; ++part, z >>= 16) sum += static_cast<double>(z & 0xffffu);
    return (sum - 4 * 32767.5) / 37837.22783634604;
  }

  void draw_numbers() {
    for (std::size_t i = 0; i < state_.size(); ++i)
      drawn_[static_cast<Eigen::Index>(i)] = normal_like(mixed_bits(state_[i] += golden_ratio_bits));
  }

  void draw() {
    draw_numbers();
    first_ = pole_ * first_ + (1 - pole_) * noise_ * drawn_;
    second_ = pole_ * second_ + (1 - pole_) * first_;
  }

  const Evidence& e_;
  double noise_, below_;  // [counts]
  Eigen::ArrayXd path_;   // [counts]
  Eigen::ArrayXi rest_;   // readings of the rest that a row is in, 0 in motion
  double pole_ = 0;
  std::vector<std::uint64_t> state_;
  Eigen::ArrayXd phase_, first_, second_, drawn_, level_, x_;
  Eigen::Index resting_ = 0;  // the same as `rest_`, of the row before
};

}  // namespace qerr::testing
