#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bound/error_columns.hpp"
#include "bound/screen_kernels.hpp"
#include "qerr/bound/figure.hpp"
#include "qerr/bound/workspace.hpp"

namespace qerr {

/// Which members of Statistic are computed; the others stay 0.
struct WantedStatistics {
  bool min = true, mean = true, max = true;
  std::vector<const StatisticKind*> percentiles;

  static WantedStatistics of(const std::vector<const StatisticKind*>&);
};

/// A figure of a model at one coordinate, whose statistics are wanted: sum_k |A_k| weight_k + added, or
/// sqrt(sum_k A_k^2 weight_k + added).
struct ColumnForm {
  const double* weights = nullptr;  ///< [column], not negative
  double added = 0;
  Statistic* statistic = nullptr;  ///< receives the result, without `at_max`
  /// Receives that of the rigorous bound, of a linear form; null: not wanted.
  Statistic* rigorous = nullptr;
  const LinearizationRemainder* remainder = nullptr;  ///< of the rigorous bound
  bool rotation = false;                              ///< of the rotation vector; else of a position
};

/// Statistics over the configurations of many models that share their columns.
///
/// Maxima and percentiles are those of the figures in double: a form is first evaluated in float, with a
/// proven bound of its rounding error, and only values that can be the wanted order statistic are evaluated
/// again in double. With n columns, u = 2^-24 and |A|, A^2 and weights rounded once, the relative error of a
/// float sum of products that are not negative is at most (n + 3) u / (1 - (n + 3) u); below the smallest
/// normal float it is an absolute one.
///
/// Results do not depend on how forms are grouped, on threads or on shards.
class ColumnStatistics {
 public:
  /// Fewer configurations are too few for the sample that says where the percentiles lie.
  static constexpr std::size_t fewest_configurations = 4096;

  /// @pre the columns are finite, and of 2^31 configurations at most, but not fewer than the above
  ColumnStatistics(const ErrorColumns&, WantedStatistics, unsigned threads = 0,
                   InstructionSet = instruction_set());

  const ErrorColumns& columns() const { return columns_; }

  /// Linear forms of a coordinate: bounds. May be called from several threads, as all functions below.
  void linear(std::size_t coordinate, std::span<const ColumnForm> forms) const {
    evaluate(coordinate, false, forms);
  }
  /// Square forms of a coordinate: sigma.
  void squared(std::size_t coordinate, std::span<const ColumnForm> forms) const {
    evaluate(coordinate, true, forms);
  }
  /// Mean of A^2 over the configurations.
  double mean_square(std::size_t coordinate, std::size_t column) const {
    return mean_square_[coordinate * count_ + column];
  }

 private:
  friend class FormStatistics;
  void evaluate(std::size_t coordinate, bool squared, std::span<const ColumnForm>) const;
  void fill(std::size_t coordinate);
  const float* block(std::size_t coordinate, bool squared) const {
    return floats_.data() + (2 * coordinate + (squared ? 1 : 0)) * count_ * padded_;
  }
  /// Columns of all coordinates, then the norms, at one configuration in double.
  const double* row(std::size_t place) const { return rows_.data() + place * row_size_; }

  const ErrorColumns& columns_;
  WantedStatistics wanted_;
  const ScreenKernels& kernels_;
  std::size_t configurations_, padded_, count_, row_size_;
  std::vector<std::uint64_t> ranks_;        // of the wanted order statistics, ascending
  std::vector<std::int32_t> order_;         // [place]: configuration, in random order
  std::vector<double> scale_;               // [coordinate]: power of two
  std::vector<char> constant_;              // [coordinate]: the same columns at all configurations
  std::vector<float> floats_;               // [coordinate][|A| or A^2][block][column][batch_size], scaled
  std::vector<double> rows_;                // [place][row_size_]
  std::vector<double> mean_, mean_square_;  // [coordinate * columns + column] of |A| and A^2
  std::vector<double> mean_norm_, least_norm_, largest_norm_;  // [moving joint]
};

/// A model whose workspace is wanted.
struct ColumnModel {
  const OperationalModel* model;
  const std::vector<Norms>* filters;
  ErrorWeights weights;
};

/// Whether ErrorColumns give a model's figures over these configurations as `workspace` does: percentiles are
/// exact, no error has a mean, and there are no lengths, no signals of other kinds and no Euler angles.
bool have_columns(const OperationalModel&, const Configurations&);

/// The statistics of `workspace` for models that share their columns, as far as reports of a sweep have them:
/// coordinates without shares, derivatives and the encoders' parts of the mean variance. They equal those of
/// `workspace` but for rounding, 1e-12 relative.
/// @pre have_columns(model, configurations) for all of them
std::vector<Workspace> workspaces(const ColumnStatistics&, std::span<const ColumnModel>);

}  // namespace qerr
