#include "residual_sums.hpp"

#include <algorithm>
#include <cmath>

namespace qerr {

namespace {

constexpr int bins = 64;             ///< of the distribution, over two counts about its middle
constexpr Eigen::Index smooth = 16;  ///< readings whose mean is the smooth part

/// Correlation of neighbours, from sums over `pairs`: of the products, of all values and their squares, of
/// the values that are nobody's left neighbour and of those that are nobody's right one.
Eigen::ArrayXd correlation(const Eigen::ArrayXd& lagged, double pairs, const Eigen::ArrayXd& sum,
                           const Eigen::ArrayXd& square, const Eigen::ArrayXd& last,
                           const Eigen::ArrayXd& first, double n) {
  const Eigen::ArrayXd variance = square / n - (sum / n).square();
  return (lagged / pairs - (sum - last) / pairs * ((sum - first) / pairs)) / variance.max(1e-6);
}

}  // namespace

ResidualSums::ResidualSums(const ResidualPlan& plan, Eigen::Index lanes)
    : plan_(plan), lanes_(lanes), distribution_(bins, lanes) {
  for (Eigen::ArrayXd* a : {&sum_, &square_, &lagged_, &last_, &block_, &block_sum_, &block_square_,
                            &block_lagged_, &last_block_, &firsts_, &lasts_, &first_blocks_, &last_blocks_})
    *a = Eigen::ArrayXd::Zero(lanes);
  distribution_.setZero();
  by_state_ = in_state_ = Eigen::ArrayXXd::Zero(4, lanes);
  for (const Projection& p : plan.projections)
    projected_.push_back(Eigen::ArrayXXd::Zero(lanes, p.columns.cols()));
  velocity_sum_ = velocity_square_ =
      Eigen::ArrayXXd::Zero(lanes, static_cast<Eigen::Index>(plan.velocities.size()));
}

void ResidualSums::start() {
  lasts_ += last_;
  last_blocks_ += last_block_;
  in_stretch_ = 0;
  blocks_in_stretch_ = 0;
  block_.setZero();
  banks_.clear();
  for (const Velocity& v : plan_.velocities) banks_.emplace_back(*v.filter, lanes_);
}

void ResidualSums::add(const Eigen::ArrayXd& r, const Eigen::ArrayXi& state) {
  sum_ += r;
  square_ += r.square();
  if (in_stretch_ > 0)
    lagged_ += r * last_;
  else
    firsts_ += r;
  last_ = r;
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
  add_block(r);
  for (std::size_t f = 0; f < banks_.size(); ++f) {
    filtered_ = r;
    banks_[f].step(filtered_);
    if (in_stretch_ < plan_.velocities[f].settling) continue;
    velocity_sum_.col(static_cast<Eigen::Index>(f)) += filtered_;
    velocity_square_.col(static_cast<Eigen::Index>(f)) += filtered_.square();
  }
  ++in_stretch_, ++row_;
}

void ResidualSums::add_block(const Eigen::ArrayXd& r) {
  block_ += r;
  if ((in_stretch_ + 1) % smooth != 0) return;
  block_ /= static_cast<double>(smooth);
  block_sum_ += block_;
  block_square_ += block_.square();
  if (blocks_in_stretch_ > 0)
    block_lagged_ += block_ * last_block_;
  else
    first_blocks_ += block_;
  last_block_ = block_;
  block_.setZero();
  ++blocks_in_stretch_, ++blocks_;
}

Eigen::ArrayXd ResidualSums::farthest_from_uniform() const {
  const auto n = static_cast<double>(row_);
  Eigen::ArrayXd farthest(lanes_);
  for (Eigen::Index i = 0; i < lanes_; ++i) {
    double below = 0, most = 0;
    for (int b = 0; b < bins; ++b) {
      below += distribution_(b, i);
      const double uniform = std::clamp((b + 1) / (0.5 * bins) - 0.5, 0.0, 1.0);
      most = std::max(most, std::abs(below / n - uniform));
    }
    farthest[i] = most;
  }
  return farthest;
}

void ResidualSums::add_correlations(std::vector<Statistic>& all) const {
  const auto n = static_cast<double>(row_), parts = static_cast<double>(plan_.parts.size());
  all.push_back({"autocorrelation", Tail::both_sides, 1, 0.01,
                 correlation(lagged_, n - parts, sum_, square_, lasts_ + last_, firsts_, n)});
  if (blocks_ <= 24 + static_cast<Eigen::Index>(parts)) return;
  const auto blocks = static_cast<double>(blocks_);
  all.push_back({"autocorrelation_smooth", Tail::both_sides, 1, 0.1,
                 correlation(block_lagged_, blocks - parts, block_sum_, block_square_,
                             last_blocks_ + last_block_, first_blocks_, blocks)});
}

void ResidualSums::add_velocities(std::vector<Statistic>& all) const {
  const auto n = static_cast<double>(row_), parts = static_cast<double>(plan_.parts.size());
  for (std::size_t f = 0; f < plan_.velocities.size(); ++f) {
    const Velocity& v = plan_.velocities[f];
    const double used = n - parts * static_cast<double>(v.settling);
    const auto column = static_cast<Eigen::Index>(f);
    const Eigen::ArrayXd variance =
        velocity_square_.col(column) / used - (velocity_sum_.col(column) / used).square();
    all.push_back({v.name, Tail::both_sides, 1, 0.05, (12 * variance).max(0.0).sqrt() / v.h2});
  }
}

std::vector<Statistic> ResidualSums::statistics() const {
  std::vector<Statistic> all;
  const auto n = static_cast<double>(row_);
  const Eigen::ArrayXd mean = sum_ / n;
  if (plan_.e->encoder.zero_known) all.push_back({"mean", Tail::both_sides, 1, 0.01, mean});
  all.push_back(
      {"sigma_ratio", Tail::both_sides, 1, 0.01, (12 * (square_ / n - mean.square())).max(0.0).sqrt()});
  all.push_back({"uniformity", Tail::both_sides, 1, 0.01, farthest_from_uniform()});
  if (plan_.e->ordered) add_correlations(all);
  for (std::size_t p = 0; p < projected_.size(); ++p) {
    const Projection& one = plan_.projections[p];
    if (one.columns.cols() == 1)
      all.push_back({one.name, Tail::both_sides, 1, 0.01, one.to_counts * projected_[p].col(0)});
    else
      all.push_back({one.name, Tail::chi_squared, 2, 0.01,
                     one.to_counts * projected_[p].square().rowwise().sum().sqrt()});
  }
  const Eigen::ArrayXXd off = by_state_ / in_state_.max(1.0) - mean.transpose().replicate(4, 1);
  all.push_back(
      {"by_count", Tail::chi_squared, 3, 0.01, (off.square() * in_state_ / n).colwise().sum().sqrt()});
  add_velocities(all);
  return all;
}

}  // namespace qerr
