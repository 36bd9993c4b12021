#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "diagnose/inference/tip/tip_evidence.hpp"
#include "diagnose/inference/tip/tip_solution.hpp"

namespace qerr {

/// Frames that are fitted as nuisance parameters.
struct UnknownFrames {
  bool base = false;    ///< of the tracker: 6 parameters
  bool target = false;  ///< the position of its target in the last link: 3 parameters

  Eigen::Index size() const { return (base ? 6 : 0) + (target ? 3 : 0); }
  bool operator==(const UnknownFrames&) const = default;
};

/// Second-order part of the error that quantization causes at the tip in one row, in the base frame:
/// -1/2 delta^T H delta, with errors delta uniform over Delta and the Hessian H of the tip's position.
struct SecondOrder {
  std::vector<Eigen::Matrix3Xd> hessian;  ///< column b of element a: d^2 tip / (d encoder a d encoder b)
  Eigen::Vector3d mean;                   ///< -1/24 sum H_aa Delta_a^2 [m]
  Eigen::Matrix3d covariance;             ///< [m^2]
};

/// The second-order part at a pose.
/// @param steps  resolutions of the encoders [rad or m]
SecondOrder second_order(const TipPose&, const Chain&, const Eigen::MatrixXd& to_joints,
                         const Eigen::VectorXd& steps);

/// Model of the tracked tip, given the readings of the encoders.
///
/// tip = FK(true joints, links as built) + white noise of the tracker; true joints = readings - additions of
/// the causes - quantization. The encoders' quantization is carried to the tip as in the bounds, with the
/// covariance (J C) diag(Delta^2/12) (J C)^T of every row, known exactly, and with the mean and the
/// covariance of its second-order part (SecondOrder), which is all that remains along a stretched arm; all
/// other white noise has one free sigma. In the axes of each row's covariance the entries are independent,
/// and the fit is a weighted least squares, linearized repeatedly about the estimate.
class TipModel {
 public:
  /// Borrows the model and the evidence: both must outlive it.
  /// @param seed    of all random numbers
  TipModel(const OperationalModel&, const TipEvidence&, UnknownFrames, std::uint64_t seed);

  void add(TipTerm, const Eigen::VectorXd& coefficients);
  void remove(std::size_t term);
  void exchange(std::size_t term, TipTerm, const Eigen::VectorXd& coefficients);

  /// Gauss-Newton iteration until the estimate converges.
  void fit();

  /// The fit at the present linearization: after a term that hardly moves the estimate came or went.
  void refit();

  /// A term's columns at the present estimate, in the rows' axes: entries x size.
  Eigen::MatrixXd columns(const TipTerm&) const;
  const Eigen::MatrixXd& columns(std::size_t term) const { return term_columns_[term]; }

  /// The fit with further columns in place of some terms (no new linearization). The nuisance comes first in
  /// theta, then the terms that are kept, then the extra columns.
  TipSolution trial(const std::vector<std::size_t>& without, const Eigen::MatrixXd& extra) const;

  /// On nuisance and terms, with the weights of the solution.
  struct Projection {
    Eigen::MatrixXd columns, weighted, inverse;
    Eigen::Index rank = 0;
  };
  Projection projection(const std::vector<std::size_t>& without) const;

  /// Columns less a projection; zero if linearly dependent.
  Eigen::MatrixXd beyond(const Projection&, const Eigen::MatrixXd& columns) const;
  /// Less that on nuisance and all terms.
  Eigen::MatrixXd beyond(const Eigen::MatrixXd& columns) const { return beyond(*projection_, columns); }
  /// A term's columns less the projection on nuisance and the other terms.
  Eigen::MatrixXd beyond_others(std::size_t term) const;

  /// Log-likelihood gain of further columns at the present weights, beside nuisance and all terms.
  double gain(const Eigen::MatrixXd& columns) const;

  /// Variance of the scores of columns over their variance if residuals were independent from row to row.
  static double variance_inflation(const TipSolution&, const Eigen::MatrixXd& columns,
                                   Eigen::Index coordinates);

  /// Variance that columns explain of the encoders' quantization error, over that of white noise of the same
  /// size; mean over encoders on the same path with random sub-count phases. Below about one count per row
  /// the quantization error is correlated with the motion, and thus with the columns.
  /// @param beyond  the part of the columns that is orthogonal to the model
  double quantization_inflation(const Eigen::MatrixXd& beyond) const;

  /// log-likelihood less what coefficients cost by Bayes' criterion (Schwarz).
  double value(const TipSolution&, Eigen::Index coefficients) const;

  const TipEvidence& evidence() const { return *evidence_; }
  /// The chain as the spec has it.
  const Chain& nominal() const { return model_->chain; }
  const TipEstimate& estimate() const { return estimate_; }
  /// Kinematics at a row, at the last linearization.
  const TipPose& pose(Eigen::Index row) const { return (*poses_)[static_cast<std::size_t>(row)]; }
  const std::vector<TipTerm>& terms() const { return terms_; }
  Eigen::Index size() const;  ///< coefficients of all terms
  Eigen::VectorXd coefficients(std::size_t term) const;
  Eigen::Index position(std::size_t term) const;  ///< of its first coefficient in theta
  UnknownFrames frames() const { return frames_; }
  std::uint64_t seed() const { return seed_; }
  const TipSolution& solution() const { return solution_; }
  const Eigen::VectorXd& entries() const { return y_; }  ///< estimate - true, without terms [m]
  /// Nuisance and terms, and room for further columns behind them.
  Eigen::MatrixXd all_columns(const std::vector<std::size_t>& without = {}, Eigen::Index more = 0) const;
  Eigen::Index nuisance() const { return nuisance_.cols(); }
  /// Mean variance of an entry by quantization and the noise of the joints' references [m^2].
  double quantization() const { return known_.mean(); }
  /// Quantization errors at the tip along the path with random sub-count phases: entries x draws [m].
  const Eigen::MatrixXd& surrogates() const { return surrogates_; }
  /// Entries, which are in the rows' own axes, as rows x coordinates.
  Eigen::MatrixXd in_base(const Eigen::VectorXd& entries) const;

 private:
  /// The columns of an addition to an encoder's reading: entries x size.
  Eigen::MatrixXd read_columns(std::size_t encoder, const Eigen::ArrayXXd& addition) const;
  void update_estimate();
  void find_second_order();
  void linearize();
  void arrange_nuisance();
  void move_frames();
  void align();
  Eigen::MatrixXd drawn_errors(std::uint64_t draw) const;
  void draw_surrogates();

  const OperationalModel* model_;
  const TipEvidence* evidence_;
  UnknownFrames frames_;
  std::uint64_t seed_;
  TipEstimate estimate_;
  std::vector<TipTerm> terms_;
  Eigen::VectorXd theta_;  ///< of the terms
  std::shared_ptr<const std::vector<TipPose>> poses_;
  /// From base axes to the row's own, coordinates x 3.
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3>> turn_;
  /// Second-order errors of every row, at the first estimate; shared by copies.
  std::shared_ptr<const std::vector<SecondOrder>> second_order_;
  Eigen::MatrixXd read_;  ///< tip per unit of each encoder's reading, in the rows' axes: entries x encoders
  Eigen::VectorXd y_, known_;
  Eigen::MatrixXd nuisance_;
  std::vector<Eigen::MatrixXd> term_columns_;
  TipSolution solution_;
  std::shared_ptr<const Projection> projection_;  ///< of all terms, at the last fit; shared by copies
  Eigen::MatrixXd surrogates_;                    ///< quantization errors at the tip, one column a draw [m]
};

}  // namespace qerr
