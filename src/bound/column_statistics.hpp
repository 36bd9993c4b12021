#pragma once

#include <span>
#include <vector>

#include "bound/error_columns.hpp"
#include "bound/histogram.hpp"
#include "bound/kernels.hpp"
#include "qerr/bound/figure.hpp"
#include "qerr/bound/workspace.hpp"

namespace qerr {

/// Which members of Statistic are computed; the others stay 0.
struct WantedStatistics {
  bool min = true, mean = true, max = true;
  std::vector<const StatisticKind*> percentiles;

  static WantedStatistics of(const std::vector<const StatisticKind*>&);
};

/// Figures that are evaluated together, so that the columns of a batch are read once.
inline constexpr std::size_t forms_per_tile = 32;

/// Statistics over the configurations of many models that share their columns.
///
/// Results do not depend on how forms are grouped, on threads or on shards.
class ColumnStatistics {
 public:
  ColumnStatistics(const ErrorColumns&, WantedStatistics, unsigned threads = 0,
                   InstructionSet = instruction_set());

  const ErrorColumns& columns() const { return columns_; }

  /// Sets the statistics of forms of a coordinate, whose columns are those of its errors, then the norms of
  /// the moving joints (ErrorColumns::norms). May be called from several threads.
  void evaluate(std::size_t coordinate, std::span<const ColumnForm> forms) const;
  /// Mean of A^2 over the configurations.
  double mean_square(std::size_t coordinate, std::size_t column) const {
    return mean_square_[coordinate * columns_.columns() + column];
  }

 private:
  std::vector<const double*> columns_from(std::size_t coordinate, std::size_t first) const;
  std::vector<LargestValues> largest_values(std::size_t coordinate, std::span<const ColumnForm>,
                                            bool sampled) const;
  void evaluate_tile(std::size_t coordinate, std::span<const ColumnForm>, double* values,
                     bool sampled = true) const;
  std::size_t wanted_values() const;
  bool keeps_all() const;
  void set(Statistic&, const JoinedTally&, const OrderStatistic&, bool squares) const;

  const ErrorColumns& columns_;
  WantedStatistics wanted_;
  const BoundKernels& kernels_;
  std::vector<double> mean_square_;  // [coordinate * columns + column]
};

/// A model whose workspace is wanted.
struct ColumnModel {
  const OperationalModel* model;
  const std::vector<Norms>* filters;
  ErrorWeights weights;
};

/// Whether ErrorColumns give a model's figures as `workspace` does: of no lengths, signals of other kinds
/// and Euler angles. Percentiles are exact, also of more configurations than exact_percentiles_limit.
bool have_columns(const OperationalModel&);

/// The statistics of `workspace` for models that share their columns, as far as reports of a sweep have them:
/// coordinates without shares, derivatives and the encoders' parts of the mean variance. They equal those of
/// `workspace` but for rounding, 1e-12 relative.
/// @pre have_columns(model) for all of them
std::vector<Workspace> workspaces(const ColumnStatistics&, std::span<const ColumnModel>);

}  // namespace qerr
