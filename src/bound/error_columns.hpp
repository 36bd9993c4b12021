#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "bound/error_columns.hpp"
#include "bound/histogram.hpp"
#include "bound/kernels.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/figure.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/bound/workspace.hpp"
#include "qerr/core/instruction_set.hpp"
#include "qerr/filter/norms.hpp"
#include "qerr/kinematics/configurations.hpp"

namespace qerr {

/// Derivative of the model's coordinates with respect to an error at a joint, an encoder or a joint's origin
/// [m or rad per unit of the error].
/// @param rotation      of the tip in the base frame
/// @param joint_rows    rows of the coordinates, by independent joints (J)
/// @param encoder_rows  the same by encoders (J C)
Eigen::VectorXd error_column(const IndependentError&, const OperationalModel&, const Eigen::VectorXd& q,
                             const Eigen::Matrix3d& rotation, const Eigen::MatrixXd& joint_rows,
                             const Eigen::MatrixXd& encoder_rows);

/// Derivatives of the tip's coordinates with respect to errors at the encoders, joints and joint origins, at
/// all sampled configurations: what models have in common that differ in their encoders, error sources and
/// filters only.
///
/// With the columns A of a coordinate (1 x columns, at one configuration) and the weights of a model
/// (ErrorWeights), the figures of `operational_error` are
///   worst case  |A| half_width + |A mean| + added_worst
///   sigma^2     A^2 variance + added_variance
/// where |A| and A^2 are taken by entry. Beside them, the norms of the position columns of the joint Jacobian
/// give the second-order remainder (LinearizationRemainder).
class ErrorColumns {
 public:
  /// @param model    chain, coupling, coordinates and frame are used; its encoders are not
  /// @param sources  of all models to be evaluated: their places get columns
  /// @param threads  0: one per core
  /// @pre size(configurations) numbers for each column and coordinate fit in memory; angles are within 2^20
  /// rad (`workspace`)
  ErrorColumns(const OperationalModel& model, const std::vector<IndependentError>& sources,
               const Configurations& configurations, unsigned threads = 0,
               InstructionSet = instruction_set());

  std::size_t configurations() const { return count_; }
  /// Of the model, then its signals of other kinds; lengths have no columns, but follow from those of their
  /// components.
  std::size_t coordinates() const { return coordinates_; }
  std::size_t columns() const { return places_.size(); }
  std::size_t joints() const { return joints_; }

  /// Column k of coordinate c, one number per configuration; aligned to 64 bytes, padded with zeros to a
  /// multiple of batch_size. At the gimbal lock, infinite at the encoders and 0 elsewhere.
  const double* column(std::size_t c, std::size_t k) const {
    return values_.data() + (c * columns() + k) * padded_;
  }
  /// Norm of the position rows of moving joint j's column of the joint Jacobian [m/rad, or 1]; laid out like
  /// `column`.
  const double* norms(std::size_t j) const { return norms_.data() + j * padded_; }

  /// The column at which a source enters. @pre its place was among those of the constructor
  std::size_t column_of(const IndependentError&) const;
  bool has_column(const IndependentError&) const;

 private:
  void set_plain(const OperationalModel&);
  void mix_batch(const OperationalModel&, std::size_t first, const double* jacobians);
  void compute_batch(const OperationalModel&, std::size_t first, const double* q, const double* jacobians);

  std::size_t count_, padded_, coordinates_, joints_;
  std::vector<IndependentError> places_;  // one per column; only where, owner, link and direction count
  bool coupled_;                          // else an error at a joint enters like one at its encoder
  /// moving joints x columns: weights of the Jacobian's columns, which is 10 times faster than one
  /// configuration at a time; empty: frames of the configuration are needed
  Eigen::MatrixXd of_joints_;
  AlignedNumbers values_, norms_;
};

/// How a model weights the columns of its coordinates.
struct ErrorWeights {
  Eigen::VectorXd half_width, mean, variance;   ///< [column] about the mean [rad or m, and squares]
  Eigen::VectorXd added_worst, added_variance;  ///< [coordinate] of the error along a motion
  LinearizationRemainder remainder;

  /// Of a coordinate behind a filter: |A| half_width ||H||_1 + |A mean| |H(1)| + added_worst, and sigma^2.
  struct Filtered {
    double l1 = 0, dc_gain = 0;
    Eigen::VectorXd variance;                  ///< [column]; empty: not known
    Eigen::VectorXd variance_in_motion;        ///< [column]; empty: not known
    Eigen::VectorXd variance_of_quantization;  ///< [column]: of it alone
    Eigen::VectorXd added_worst, added_variance;
  };
  std::vector<Filtered> filtered;

  /// Whether the model's errors have a mean: else |A mean| is 0.
  bool biased() const { return !mean.isZero(0); }
};

/// @param noise_in_motion  as in WorkspaceOptions
/// @pre the model has the chain, coupling and coordinates of the columns, and sources at their places
ErrorWeights error_weights(const ErrorColumns&, const OperationalModel&, const std::vector<Norms>& filters,
                           const std::vector<Eigen::VectorXd>& noise_in_motion = {});

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
