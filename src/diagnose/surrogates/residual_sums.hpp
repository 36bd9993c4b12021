#pragma once

#include <cstdint>
#include <vector>

#include "diagnose/surrogates/residual_filter.hpp"
#include "diagnose/surrogates/residual_plan.hpp"
#include "diagnose/surrogates/residual_statistics.hpp"

namespace qerr {

/// Mean, variance and correlation of neighbours, of numbers that come in stretches.
class Moments {
 public:
  Moments(std::size_t width, const ResidualKernels&);

  /// To the beginning of a stretch.
  void start();

  /// The next rows. @param in  [row][lane]
  void add(const double* in, std::size_t rows);

  double rows() const { return static_cast<double>(rows_); }
  Eigen::ArrayXd mean() const { return of(sum_) / rows(); }
  Eigen::ArrayXd variance() const { return of(square_) / rows() - mean().square(); }

  /// Of neighbours within a stretch.
  /// @param stretches  how many there were
  Eigen::ArrayXd correlation(double stretches) const;

 private:
  static Eigen::ArrayXd of(const AlignedNumbers&);

  const ResidualKernels* kernels_;
  std::size_t width_, rows_ = 0;
  bool begins_ = true;
  AlignedNumbers sum_, square_, lagged_, last_;
  AlignedNumbers firsts_, lasts_;  // sums of those at the ends of the stretches, without the last end
};

/// Sums over the rows of residuals of several lanes, stretch by stretch, and the statistics that they make.
class ResidualSums {
 public:
  /// Rows at a time: what is known of them stays in the first-level cache. Whole means of neighbours.
  static constexpr std::size_t most_rows = 32;

  ResidualSums(const ResidualPlan&, std::size_t width, const ResidualKernels&);

  /// To the beginning of a stretch.
  void start();

  /// The next rows: most_rows of them, less only at the end of a stretch.
  /// @param r      residuals of the lanes [counts], [row][lane]
  /// @param state  the readings' counts modulo four
  void add(const double* r, const double* state, std::size_t rows);

  /// Of every lane.
  std::vector<ResidualStatistic> statistics() const;

 private:
  void add_velocities(const double* r, std::size_t rows);
  Eigen::ArrayXd farthest_from_uniform() const;
  Eigen::ArrayXd by_count() const;
  void add_correlations(std::vector<ResidualStatistic>&) const;
  void add_projections(std::vector<ResidualStatistic>&) const;

  const ResidualPlan& plan_;
  const ResidualKernels& kernels_;
  std::size_t width_, row_ = 0, in_stretch_ = 0;
  Moments moments_, smooth_;
  std::vector<Moments> velocities_;
  std::vector<ResidualFilter> filters_;
  std::vector<std::int32_t> places_;
  std::vector<std::uint32_t> bins_;
  AlignedNumbers by_state_, in_state_;     // [state][lane]
  std::vector<AlignedNumbers> projected_;  // [column][lane]
  AlignedNumbers room_;                    // [row][lane]
};

}  // namespace qerr
