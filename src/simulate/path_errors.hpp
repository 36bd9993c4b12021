#pragma once

#include <algorithm>
#include <vector>

#include "kinematics/folded_chain.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/operational_error.hpp"
#include "simulate/kernels.hpp"
#include "simulate/run_statistics.hpp"
#include "simulate/sensing.hpp"

namespace qerr {

/// Layout of the filtered signals of every coordinate: the exact error, its linear part J e, the contribution
/// of every encoder to that, and, if errors have a mean, the mean error along the path.
struct Channels {
  Eigen::Index coordinates, encoders;
  bool biased;

  explicit Channels(const OperationalModel& model)
      : coordinates(std::ssize(model.coordinates)),
        encoders(std::ssize(model.transmission.encoders)),
        biased((mean_errors(model.transmission).array() != 0).any() ||
               std::ranges::any_of(model.sources,
                                   [](const IndependentError& source) { return source.mean != 0; })) {}

  Eigen::Index count() const { return coordinates * (2 + encoders + (biased ? 1 : 0)); }
  Eigen::Index linear() const { return coordinates; }
  Eigen::Index part(Eigen::Index encoder) const { return coordinates * (2 + encoder); }
  Eigen::Index mean() const { return coordinates * (2 + encoders); }
};

/// Errors of the tip along a run, a batch of instants at a time: at each instant equal to `tip_error` and
/// `operational_error` up to rounding.
class PathErrors {
 public:
  /// @param built        the chain as it was built
  /// @param center_mean  of the error at the centre of the motion
  PathErrors(const OperationalModel&, const Chain& built, const Eigen::VectorXd& center_mean,
             InstructionSet = instruction_set());

  /// Computes the quantities that several runs along this path share, valid until the next call.
  void share(const PathBatch&);

  /// @pre the batch is full; after the end of a motion its last instant is repeated
  void operator()(const SensedBatch&);

  /// Width of a row: the number of channels, padded to whole lanes.
  std::size_t width() const { return plan_.width; }
  /// Channels of the last batch, [instant][width].
  const double* rows() const { return rows_.data(); }

  /// The sum over the instants first .. last - 1 of the last batch, and over all encoders, of (J C Delta)^2.
  double variance(Eigen::Index coordinate, std::size_t first, std::size_t last) const {
    const double* const values = variance_.data() + static_cast<std::size_t>(coordinate) * batch_size;
    return Eigen::Map<const Eigen::ArrayXd>(values + first, last - first).sum();
  }
  /// Largest bounds over all batches so far: of the error, and of its difference from the mean at the centre.
  Eigen::VectorXd rigorous() const { return largest(rigorous_); }
  Eigen::VectorXd deviation() const { return largest(deviation_); }

 private:
  void add_columns(const OperationalModel&);
  void add_column(const Chain&, const Eigen::VectorXd& of_independent, double mean, double half_width);
  void add_origin(const IndependentError&);
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
  bool shared_ = false;
  AlignedNumbers path_sines_;
  std::vector<Displacement> displacements_;
  AlignedNumbers rows_, variance_, rigorous_, deviation_, scratch_;

  // For angles beyond the range of the vectorized sine: the same chains with angles reduced to one turn.
  std::vector<FoldedJoint> direct_chain_, direct_built_;
  AlignedNumbers direct_joint_, direct_built_joint_, direct_estimate_;
};

}  // namespace qerr
