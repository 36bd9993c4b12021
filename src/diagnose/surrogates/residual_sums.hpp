#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "diagnose/surrogates/residual_kernels.hpp"
#include "diagnose/surrogates/surrogate.hpp"
#include "filter/run/cascade.hpp"
#include "qerr/filter/filter.hpp"

namespace qerr {

/// Orthonormal columns without their means on which the residual is projected.
struct Projection {
  std::string name;
  Eigen::ArrayXXd columns;  ///< rows x 1 or 2
  double to_counts = 1;     ///< factor from the projection to the reported statistic
};

/// A derivative filter that is applied to the residual.
struct FilteredResidual {
  std::string name;
  const Filter* filter;   ///< must outlive the plan
  Eigen::Index settling;  ///< rows until the initial transient has decayed
  double h2;              ///< H2 norm
};

/// What the record and all surrogates have in common. The evidence and the filters must outlive it.
struct ResidualPlan {
  const Evidence* e;
  std::vector<RowRange> ranges;
  Eigen::Index rows = 0;  ///< of all ranges
  std::vector<Projection> projections;
  std::vector<FilteredResidual> velocities;
  Eigen::ArrayXd residual;  ///< of the record in these rows [counts]
  Eigen::ArrayXd state;     ///< counts of the record, modulo four
  SurrogatePlan surrogates;
};

/// Selects the rows that are evaluated and the statistics of their residuals.
ResidualPlan residual_plan(const Evidence&, const std::vector<Filter>&, InstructionSet = instruction_set());

/// Mean, variance and lag-one autocorrelation of values in several ranges of rows, per lane.
class Moments {
 public:
  Moments(std::size_t width, const ResidualKernels&);

  /// Starts a new range.
  void start();

  /// Adds the next rows. @param in  [row][lane]
  void add(const double* in, std::size_t rows);

  double rows() const { return static_cast<double>(rows_); }
  Eigen::ArrayXd mean() const { return of(sum_) / rows(); }
  Eigen::ArrayXd variance() const { return of(square_) / rows() - mean().square(); }

  /// Of neighbours within a range.
  /// @param ranges  number of ranges
  Eigen::ArrayXd correlation(double ranges) const;

 private:
  static Eigen::ArrayXd of(const AlignedNumbers&);

  const ResidualKernels* kernels_;
  std::size_t width_, rows_ = 0;
  bool begins_ = true;
  AlignedNumbers sum_, square_, lagged_, last_;
  AlignedNumbers firsts_,
      lasts_;  // sums of the first and last values of the ranges, without the present range's last
};

/// Sums over the rows of the residuals of several lanes, and the statistics that follow from them. The plan
/// must outlive this object.
class ResidualSums {
 public:
  /// Rows per call: their data fit the first-level cache; a multiple of the length of the means.
  static constexpr std::size_t most_rows = 32;

  ResidualSums(const ResidualPlan&, std::size_t width, InstructionSet);
  ResidualSums(const ResidualSums&) = delete;
  ResidualSums& operator=(const ResidualSums&) = delete;

  /// Starts a new range.
  void start();

  /// Adds the next rows: most_rows of them, fewer only at the end of a range.
  /// @param r      residuals of the lanes [counts], [row][lane]
  /// @param state  counts modulo four
  void add(const double* r, const double* state, std::size_t rows);

  /// For every lane.
  std::vector<ResidualStatistic> statistics() const;

 private:
  void add_velocities(const double* r, std::size_t rows);
  Eigen::ArrayXd distance_from_uniform() const;
  Eigen::ArrayXd by_count() const;
  void add_correlations(std::vector<ResidualStatistic>&) const;
  void add_projections(std::vector<ResidualStatistic>&) const;

  const ResidualPlan& plan_;
  const ResidualKernels& kernels_;
  std::size_t width_, row_ = 0, in_range_ = 0;
  Moments moments_, smooth_;
  std::vector<Moments> velocities_;
  std::vector<RowFilter> filters_;
  std::vector<std::int32_t> places_;
  std::vector<std::uint32_t> bins_;
  AlignedNumbers by_state_, in_state_;     // [state][lane]
  std::vector<AlignedNumbers> projected_;  // [column][lane]
  AlignedNumbers scratch_;                 // [row][lane]
};

}  // namespace qerr
