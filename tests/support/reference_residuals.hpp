#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "diagnose/surrogates/residual_sums.hpp"
#include "diagnose/surrogates/surrogate.hpp"
#include "support/reference_filter.hpp"
#include "support/reference_surrogate.hpp"

/// The statistics of residuals (residual_statistics.hpp) in plain code without vector kernels.
namespace qerr::testing {

class ReferenceSums {
 public:
  ReferenceSums(const ResidualPlan& plan, Eigen::Index lanes)
      : plan_(plan), lanes_(lanes), zero_(Eigen::ArrayXd::Zero(lanes)), distribution_(bins, lanes) {
    distribution_.setZero();
    by_state_ = in_state_ = Eigen::ArrayXXd::Zero(4, lanes);
    for (Sums* s : {&all_, &smooth_}) *s = {zero_, zero_, zero_, zero_, zero_, zero_, 0};
    for (const Projection& p : plan.projections)
      projected_.push_back(Eigen::ArrayXXd::Zero(lanes, p.columns.cols()));
    velocity_.assign(plan.velocities.size(), all_);
  }

  void start() {
    for (Sums* s : {&all_, &smooth_}) s->lasts += s->last;
    in_stretch_ = 0;
    block_ = zero_;
    banks_.clear();
    for (const FilteredResidual& v : plan_.velocities) banks_.emplace_back(*v.filter, lanes_);
  }

  void add(const Eigen::ArrayXd& r, const Eigen::ArrayXi& state) {
    add(all_, r, in_stretch_ == 0);
    for (std::size_t p = 0; p < projected_.size(); ++p)
      for (Eigen::Index c = 0; c < projected_[p].cols(); ++c)
        projected_[p].col(c) += plan_.projections[p].columns(row_, c) * r;
    const double middle = plan_.e->encoder.rounding == Rounding::down ? -0.5 : 0.0;
    for (Eigen::Index i = 0; i < lanes_; ++i) {
      const double place = (r[i] - middle + 1) * (0.5 * bins);
      ++distribution_(static_cast<int>(std::clamp(place, 0.0, bins - 0.5)), i);
      by_state_(state[i], i) += r[i];
      in_state_(state[i], i) += 1;
    }
    block_ += r;
    if ((in_stretch_ + 1) % smooth == 0) {
      add(smooth_, block_ / static_cast<double>(smooth), in_stretch_ < smooth);
      block_ = zero_;
    }
    for (std::size_t f = 0; f < banks_.size(); ++f) {
      filtered_ = r;
      banks_[f].step(filtered_);
      if (in_stretch_ >= plan_.velocities[f].settling) add(velocity_[f], filtered_, true);
    }
    ++in_stretch_, ++row_;
  }

  std::vector<ResidualStatistic> statistics() const {
    std::vector<ResidualStatistic> all;
    const auto sigma = [](const Sums& s) -> Eigen::ArrayXd { return (12 * variance(s)).max(0.0).sqrt(); };
    const Eigen::ArrayXd mean = all_.sum / all_.rows;
    if (plan_.e->encoder.zero_known) all.push_back({"mean", Tail::both_sides, 1, 0.01, mean});
    all.push_back({"sigma_ratio", Tail::both_sides, 1, 0.01, sigma(all_)});
    all.push_back({"uniformity", Tail::both_sides, 1, 0.01, farthest_from_uniform()});
    if (plan_.e->ordered) {
      const auto parts = static_cast<double>(plan_.ranges.size());
      all.push_back({"autocorrelation", Tail::both_sides, 1, 0.01, correlation(all_, parts)});
      if (smooth_.rows > 24 + parts)
        all.push_back({"autocorrelation_smooth", Tail::both_sides, 1, 0.1, correlation(smooth_, parts)});
    }
    for (std::size_t p = 0; p < projected_.size(); ++p) {
      const Projection& one = plan_.projections[p];
      if (one.columns.cols() == 1)
        all.push_back({one.name, Tail::both_sides, 1, 0.01, one.to_counts * projected_[p].col(0)});
      else
        all.push_back({one.name, Tail::chi_squared, 2, 0.01,
                       one.to_counts * projected_[p].square().rowwise().sum().sqrt()});
    }
    const Eigen::ArrayXXd off = by_state_ / in_state_.max(1.0) - mean.transpose().replicate(4, 1);
    all.push_back({"by_count", Tail::chi_squared, 3, 0.01,
                   (off.square() * in_state_ / all_.rows).colwise().sum().sqrt().transpose()});
    for (std::size_t f = 0; f < velocity_.size(); ++f)
      all.push_back({plan_.velocities[f].name, Tail::both_sides, 1, 0.05,
                     sigma(velocity_[f]) / plan_.velocities[f].h2});
    return all;
  }

 private:
  static constexpr int bins = 64;
  static constexpr Eigen::Index smooth = 16;

  struct Sums {
    Eigen::ArrayXd sum, square, lagged, last, firsts, lasts;
    double rows = 0;
  };

  static void add(Sums& s, const Eigen::ArrayXd& x, bool begins) {
    s.sum += x;
    s.square += x.square();
    if (begins)
      s.firsts += x;
    else
      s.lagged += x * s.last;
    s.last = x;
    ++s.rows;
  }

  static Eigen::ArrayXd variance(const Sums& s) { return s.square / s.rows - (s.sum / s.rows).square(); }

  static Eigen::ArrayXd correlation(const Sums& s, double parts) {
    const double pairs = s.rows - parts;
    const Eigen::ArrayXd last = s.lasts + s.last;
    return (s.lagged / pairs - (s.sum - last) / pairs * ((s.sum - s.firsts) / pairs)) / variance(s).max(1e-6);
  }

  Eigen::ArrayXd farthest_from_uniform() const {
    Eigen::ArrayXd farthest(lanes_);
    for (Eigen::Index i = 0; i < lanes_; ++i) {
      double below = 0, most = 0;
      for (int b = 0; b < bins; ++b) {
        below += distribution_(b, i);
        const double uniform = std::clamp((b + 1) / (0.5 * bins) - 0.5, 0.0, 1.0);
        most = std::max(most, std::abs(below / all_.rows - uniform));
      }
      farthest[i] = most;
    }
    return farthest;
  }

  const ResidualPlan& plan_;
  Eigen::Index lanes_, row_ = 0, in_stretch_ = 0;
  Eigen::ArrayXd zero_, block_, filtered_;
  Eigen::ArrayXXi distribution_;
  Eigen::ArrayXXd by_state_, in_state_;
  Sums all_, smooth_;
  std::vector<Sums> velocity_;
  std::vector<Eigen::ArrayXXd> projected_;
  std::vector<ReferenceFilter> banks_;
};

/// `residual_statistics`, row by row.
inline std::vector<ResidualStatistic> reference_statistics(const Evidence& e,
                                                           const std::vector<Filter>& filters,
                                                           Eigen::Index surrogates, std::uint64_t seed) {
  const ResidualPlan plan = residual_plan(e, filters);
  ReferenceSurrogates drawn(e, seed, surrogates + 1);
  ReferenceSums sums(plan, surrogates + 1);
  Eigen::ArrayXd residual(surrogates + 1);
  Eigen::ArrayXi state(surrogates + 1);
  Eigen::Index row = 0;
  for (const RowRange& s : plan.ranges) {
    drawn.start();
    sums.start();
    for (Eigen::Index k = s.first; k < s.first + s.rows; ++k, ++row) {
      drawn.read(k, residual, state);
      residual[0] = plan.residual[row], state[0] = static_cast<int>(plan.state[row]);
      sums.add(residual, state);
    }
  }
  return sums.statistics();
}

}  // namespace qerr::testing
