#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "diagnose/inference/tip/tip_solution.hpp"
#include "diagnose/inference/tip/tip_term.hpp"

namespace qerr {

/// A model of where a tracker sees the tip, given what the joints' encoders read.
///
/// tip = FK(true joints, links as built) + white noise of the tracker, true joints = as read - what causes
/// add - quantization. The encoders' quantization is carried to the tip as in the bounds, with the covariance
/// (J C) diag(Delta^2/12) (J C)^T of every row, known exactly; all else that is white is one free sigma. In
/// the axes of each row's covariance the entries are independent, and the fit is a weighted least squares,
/// linearized anew where the belief has moved.
class TipModel {
 public:
  /// Borrows the model and the evidence: both must outlive it.
  /// @param seed    of all that is drawn with it
  /// @param frames  whether the tracker's frame and its target are unknown: 9 numbers that are nobody's fault
  TipModel(const OperationalModel&, const TipEvidence&, bool frames, std::uint64_t seed);

  void add(TipTerm, const Eigen::VectorXd& coefficients);
  void remove(std::size_t term);
  void exchange(std::size_t term, TipTerm, const Eigen::VectorXd& coefficients);

  /// Newton and Gauss: until the belief rests.
  void fit();

  /// A term's columns at the present belief, in the rows' axes: entries x size.
  Eigen::MatrixXd columns(const TipTerm&) const;

  /// The fit with further columns in place of some terms (no new linearization). The nuisance comes first in
  /// theta, then the terms that are kept, then the extra columns.
  TipSolution trial(const std::vector<std::size_t>& without, const Eigen::MatrixXd& extra) const;

  /// Columns less what nuisance and terms (but those without) can make of them; zero where nothing is left.
  Eigen::MatrixXd beyond(const std::vector<std::size_t>& without, const Eigen::MatrixXd& columns) const;

  /// How much more scores of columns scatter than they would if what is left were independent from row to
  /// row.
  static double inflation(const TipSolution&, const Eigen::MatrixXd& columns, Eigen::Index coordinates);

  /// How much more of the encoders' quantization columns would explain than of white noise of its size, on
  /// average over encoders that go the same way and begin at other parts of a count. At less than about a
  /// count per row quantization follows the motion, as what columns describe does.
  /// @param beyond  what the model cannot make of the columns
  double quantization_inflation(const Eigen::MatrixXd& beyond) const;

  /// log-likelihood less what coefficients cost by Bayes' criterion (Schwarz).
  double value(const TipSolution&, Eigen::Index coefficients) const;

  const TipEvidence& evidence() const { return *evidence_; }
  const TipBelief& belief() const { return belief_; }
  const std::vector<TipTerm>& terms() const { return terms_; }
  Eigen::Index size() const;  ///< coefficients of all terms
  Eigen::VectorXd coefficients(std::size_t term) const;
  Eigen::Index position(std::size_t term) const;  ///< of its first coefficient in theta
  bool frames() const { return frames_; }
  std::uint64_t seed() const { return seed_; }
  const TipSolution& solution() const { return solution_; }
  const Eigen::VectorXd& entries() const { return y_; }  ///< estimate - true with no term taken off [m]
  Eigen::MatrixXd all_columns(const std::vector<std::size_t>& without = {}) const;  ///< nuisance and terms
  Eigen::Index nuisance() const { return nuisance_.cols(); }

 private:
  void believe();
  void linearize();
  void arrange_nuisance();
  void move_frames();
  void align();
  void draw_surrogates();

  const OperationalModel* model_;
  const TipEvidence* evidence_;
  bool frames_;
  std::uint64_t seed_;
  TipBelief belief_;
  std::vector<TipTerm> terms_;
  Eigen::VectorXd theta_;  ///< of the terms
  std::shared_ptr<const std::vector<TipPose>> poses_;
  std::vector<Eigen::MatrixXd> turn_;  ///< from base axes to the row's own, coordinates x 3
  Eigen::VectorXd y_, known_;
  Eigen::MatrixXd nuisance_;
  std::vector<Eigen::MatrixXd> term_columns_;
  TipSolution solution_;
  Eigen::MatrixXd surrogates_;  ///< quantization errors at the tip, one column a draw [m]
};

}  // namespace qerr
