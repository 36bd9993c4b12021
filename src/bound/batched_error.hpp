#pragma once

#include <memory>
#include <vector>

#include "bound/figure_layout.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/core/instruction_set.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

/// What `BatchedError` works out beside worst case and sigma.
struct ErrorFigures {
  bool rigorous = true;     ///< the bound with the second-order remainder
  bool shares = true;       ///< what each encoder contributes, its largest arm, and the position's variance
  bool covariance = false;  ///< of every configuration, instead of sigma and the sum
  /// Norms of filters, and sigma of each encoder's error behind them in a motion, in quantization intervals
  /// (empty where it is not known): figures behind filters, where they are not the coordinate's times a norm.
  std::vector<Norms> filters = {};
  std::vector<Eigen::VectorXd> noise_in_motion = {};
};

/// `operational_error` and `derivative_error` of batches of configurations, several at once in the lanes of
/// the processor. The scalar functions are the reference, from which the figures differ by rounding, some
/// 1e-15 of the largest; equations and assumptions stand there.
///
/// Copies share nothing that is written to: one for each thread.
class BatchedError {
 public:
  BatchedError(const OperationalModel&, const ErrorFigures&, InstructionSet = instruction_set());
  BatchedError(const BatchedError&);
  ~BatchedError();

  const FigureLayout& figures() const;
  const SumLayout& sums() const;

  /// Whether worst cases behind a filter are figures of their own, not the position's times ||H||_1; the same
  /// of sigma and ||H||_2.
  bool own_worst_case() const;
  bool own_sigma() const;

  /// Figures of a batch, and its part of the sums.
  /// @param q        configuration c of independent joint i at q[i * batch_size + c]; aligned to 64 bytes
  /// @param figures  receives figures().count * batch_size numbers; aligned to 64 bytes
  /// @pre |angles| <= 2^20 rad, beyond which sines lose digits (lanes.hpp)
  void operator()(const double* q, double* figures);

  /// The sums over all batches since the last call, in the order of sums(), which start anew.
  std::vector<double> take_sums();

 private:
  struct Plan;
  std::shared_ptr<const Plan> plan_;
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace qerr
