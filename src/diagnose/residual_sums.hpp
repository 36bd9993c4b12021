#pragma once

#include <vector>

#include "qerr/filter/filter_bank.hpp"
#include "residual_plan.hpp"
#include "residual_statistics.hpp"

namespace qerr {

/// Sums over the rows of residuals of several lanes, stretch by stretch, and the statistics that they make.
class ResidualSums {
 public:
  ResidualSums(const ResidualPlan&, Eigen::Index lanes);

  /// To the beginning of a stretch.
  void start();

  /// The next row.
  /// @param r      residuals of the lanes [counts]
  /// @param state  the readings' counts modulo four
  void add(const Eigen::ArrayXd& r, const Eigen::ArrayXi& state);

  std::vector<Statistic> statistics() const;

 private:
  void add_block(const Eigen::ArrayXd& r);
  Eigen::ArrayXd farthest_from_uniform() const;
  void add_correlations(std::vector<Statistic>&) const;
  void add_velocities(std::vector<Statistic>&) const;

  const ResidualPlan& plan_;
  Eigen::Index lanes_, row_ = 0, in_stretch_ = 0, blocks_in_stretch_ = 0, blocks_ = 0;
  Eigen::ArrayXd sum_, square_, lagged_, last_, block_, block_sum_, block_square_, block_lagged_, last_block_,
      firsts_, lasts_, first_blocks_, last_blocks_;
  Eigen::ArrayXd filtered_;
  Eigen::ArrayXXi distribution_;
  Eigen::ArrayXXd by_state_, in_state_, velocity_sum_, velocity_square_;
  std::vector<Eigen::ArrayXXd> projected_;
  std::vector<FilterBank> banks_;
};

}  // namespace qerr
