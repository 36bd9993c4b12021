#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "bound/kernels.hpp"
#include "kinematics/folded_chain.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/figure.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/core/instruction_set.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

/// Consecutive configurations and their figures. Borrows the arrays for the duration of a call.
struct ConfigurationBatch {
  std::uint64_t first;    ///< index of the first one
  std::size_t count;      ///< up to batch_size
  const double* q;        ///< configuration c of joint i at q[i * batch_size + c] [rad or m]
  const double* figures;  ///< figure i of it at figures[i * batch_size + c]
  const FigureLayout& layout;
};

/// Where a figure stands in a batch, and the norm by which it is multiplied.
struct FigureColumn {
  std::size_t figure;
  double factor;
};

/// @pre the batch has the figure
FigureColumn figure_column(const Figure&, const std::vector<Norms>& filters, const FigureLayout&);

/// Figures that `BatchedError` computes besides worst case and sigma.
struct ErrorFigures {
  bool rigorous = true;  ///< the bound with the second-order remainder
  bool shares = true;    ///< the encoders' contributions and largest arms, and the variance of the position
  bool covariance = false;  ///< covariance of every configuration instead of sigma and the sum
  /// Norms of filters, and sigma of each encoder's error behind each of them in a motion [quantization
  /// intervals] (empty: unknown). They add figures behind filters that are not the coordinate's times a norm.
  std::vector<Norms> filters = {};
  std::vector<Eigen::VectorXd> noise_in_motion = {};
};

/// `operational_error` and `derivative_error` (equations and assumptions there) of batches of configurations,
/// one configuration per vector lane. The figures differ from those functions by rounding, about 1e-15 of the
/// largest.
///
/// A copy per thread: copies share only constants.
class BatchedError {
 public:
  BatchedError(const OperationalModel&, const ErrorFigures&, InstructionSet = instruction_set());
  BatchedError(const BatchedError&);
  ~BatchedError();

  const FigureLayout& figures() const;
  const SumLayout& sums() const;

  /// Whether worst cases behind a filter are separate figures rather than the position's times ||H||_1, and
  /// sigmas rather than the position's times ||H||_2.
  bool own_worst_case() const;
  bool own_sigma() const;
  /// Whether contributions of quantization are separate sums (SumLayout::quantization_parts).
  bool has_sources() const;

  /// Computes the figures of a batch and adds to the sums.
  /// @param q        configuration c of independent joint i at q[i * batch_size + c]; aligned to 64 bytes
  /// @param figures  receives figures().count * batch_size numbers; aligned to 64 bytes
  /// @pre |angles| <= 2^20 rad, beyond which sines lose accuracy (lanes.hpp)
  void operator()(const double* q, double* figures);

  /// Returns the sums over all batches since the last call, in the order of sums(), and resets them.
  std::vector<double> take_sums();

 private:
  struct Plan;
  std::shared_ptr<const Plan> plan_;
  struct Work;
  std::unique_ptr<Work> work_;
};

/// Builds an ErrorPlan from a model and owns the arrays that it points to.
class PlannedError {
 public:
  PlannedError(const OperationalModel&, const ErrorFigures&);
  PlannedError(const PlannedError&) = delete;
  PlannedError& operator=(const PlannedError&) = delete;

  const ErrorPlan& plan() const { return plan_; }

 private:
  void set_coordinates(const OperationalModel&);
  void add_errors(const OperationalModel&);
  /// @param scale  of which the part's sizes are multiples
  void add_error(const OperationalModel&, const IndependentError&, bool source, double scale);
  void set_direct();
  void share_scale();
  void set_remainder(const OperationalModel&);
  void set_filters(const OperationalModel&, const ErrorFigures&);
  void set_layout(const ErrorFigures&, std::size_t others);

  ErrorPlan plan_ = {};
  FoldedChain chain_;
  std::vector<double> column_scale_, per_column_, arm_, l1_, dc_gain_, ratio_squares_, motion_squares_;
  std::vector<int> coordinate_;
  std::vector<ErrorPart> parts_;
  std::vector<std::vector<JointWeight>> weights_;  // [part]
};

}  // namespace qerr
