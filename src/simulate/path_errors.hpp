#pragma once

#include <vector>

#include "kinematics/folded_chain.hpp"
#include "lanes/aligned.hpp"
#include "simulate/channels.hpp"
#include "simulate/kernels.hpp"
#include "simulate/run_statistics.hpp"
#include "simulate/sensing.hpp"

namespace qerr {

/// Errors of the tip along a run, a batch of instants at a time: what `tip_error` and `operational_error`
/// give at each, from which they differ by rounding.
class PathErrors {
 public:
  /// @param built        the chain as it was built
  /// @param center_mean  of the error at the centre of the motion
  PathErrors(const OperationalModel&, const Chain& built, const Eigen::VectorXd& center_mean,
             InstructionSet = instruction_set());

  /// What is done with the squares (J C Delta)^2 of a batch.
  enum class Squares {
    dropped,
    summed,  ///< added to one sum over instants and batches
    kept     ///< added, instant by instant, to those of other batches of the same instants
  };
  struct Wanted {
    bool rows = true;
    Squares squares = Squares::kept;
    RunStatistics* statistics = nullptr;  ///< to which all instants are added, in
    std::uint64_t block = 0;
    bool each = true;  ///< the variances of single instants too, not only those of the batch
  };

  /// Several runs follow along this path: what they share is worked out once. Until the next call.
  void share(const PathBatch&);

  /// @pre the batch is full; behind the end of a motion its last instant stands again and again
  void operator()(const SensedBatch&, const Wanted&);

  /// Of a row of channels: their count, filled up to whole lanes.
  std::size_t width() const { return plan_.width; }
  /// Channels of the last batch, [instant][width].
  const double* rows() const { return rows_.data(); }

  /// The sum over the instants first .. last - 1 of the last batch, and over all encoders, of (J C Delta)^2.
  /// @pre they are all of the batch, or those of each were wanted
  double variance(Eigen::Index coordinate, std::size_t first, std::size_t last) const {
    const double* const of = variance_.data() + static_cast<std::size_t>(coordinate) * batch_size;
    return each_ ? kernels_.sum_between(of, first, last) : kernels_.sum_between(of, 0, kernels_.lanes);
  }

  /// Adds the squares that were summed up since the last call to those of a stretch.
  void take_summed(double* squares);
  /// The squares that were kept since the last call, in rows that `add_kept` takes.
  void take_kept() { kernels_.turn(kept_.data(), plan_.squares_width, kept_rows_.data()); }
  void add_kept(std::size_t first, std::size_t last, double* squares) const {
    kernels_.add_rows(kept_rows_.data(), plan_.squares_width, first, last, squares);
  }

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
  bool displace(const double* shift);
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
  bool shared_ = false, each_ = true;
  AlignedNumbers path_sines_;
  std::vector<Displacement> turns_;
  AlignedNumbers rows_, variance_, kept_, kept_rows_, summed_, rigorous_, deviation_, room_;

  // For angles beyond those of the lanes' sine: the same chains, moved by angles within a turn.
  std::vector<FoldedJoint> direct_chain_, direct_built_;
  AlignedNumbers direct_joint_, direct_built_joint_, direct_estimate_;
};

}  // namespace qerr
