#pragma once

#include <vector>

#include "channels.hpp"
#include "kernels.hpp"
#include "qerr/core/aligned.hpp"
#include "qerr/kinematics/folded_chain.hpp"
#include "qerr/simulate/sensing.hpp"
#include "theory_along_path.hpp"

namespace qerr {

/// Errors of the tip along a run, a batch of instants at a time: what `tip_error` and `operational_error`
/// give at each, from which they differ by rounding.
class PathErrors {
 public:
  /// @param built        the chain as it was built
  /// @param center_mean  of the error at the centre of the motion
  PathErrors(const OperationalModel&, const Chain& built, const Eigen::VectorXd& center_mean,
             InstructionSet = instruction_set());

  /// @param parts  whether sums over parts of the batch will be asked for, not only over all of it
  /// @pre the batch is full; behind the end of a motion its last instant stands again and again
  void operator()(const SensedBatch&, bool parts = true);

  std::size_t width() const { return plan_.width; }
  /// Channels of the last batch, [instant][width].
  const double* rows() const { return rows_.data(); }

  /// Sum of (J C Delta)^2, coordinates x encoders, over the instants first .. last - 1 of the last batch;
  /// until the next call.
  Eigen::Map<const Eigen::MatrixXd> squares(std::size_t first = 0, std::size_t last = batch_size);

  /// The largest bounds over all batches so far: of the error, and of its difference from the mean.
  Eigen::VectorXd rigorous() const { return largest(rigorous_); }
  Eigen::VectorXd deviation() const { return largest(deviation_); }

 private:
  void add_columns(const OperationalModel&);
  void add_column(const Chain&, const Eigen::VectorXd& of_independent, double mean, double half_width);
  void add_origin(const Chain&, const ErrorSource&);
  void fix_scale(const OperationalModel&);
  void bound(const OperationalModel&);
  void set_plan(const OperationalModel&);
  bool within_lanes(const FoldedChain&, const double* joints) const;
  void reduce_angles(const FoldedChain&, const double* joints, const AlignedNumbers& to) const;
  Eigen::VectorXd largest(const AlignedNumbers&) const;

  Channels channels_;
  FoldedChain chain_, built_;
  bool as_modelled_;
  const SimulationKernels& kernels_;
  std::vector<double> scale_, per_resolution_, per_column_, center_mean_;
  std::vector<ErrorColumn> columns_;
  std::vector<ColumnPart> parts_;
  std::vector<int> coordinates_;
  PathErrorPlan plan_{};
  bool summed_ = false;
  AlignedNumbers rows_, squares_, squares_sum_, rigorous_, deviation_, room_;

  // For angles beyond those of the lanes' sine: the same chains, moved by angles within a turn.
  std::vector<FoldedJoint> direct_chain_, direct_built_;
  AlignedNumbers direct_joint_, direct_built_joint_, direct_estimate_;
};

}  // namespace qerr
