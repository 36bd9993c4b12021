#pragma once

#include <Eigen/Core>
#include <vector>

namespace qerr {

/// The first element of each of some columns, which their owner keeps.
using Columns = std::vector<const double*>;

Columns columns_of(const Eigen::MatrixXd&);

/// Z^T W Z of Z = [columns, y, 1] and the weights' diagonal matrix W.
Eigen::MatrixXd weighted_gram(const Columns&, const Eigen::VectorXd& y, const Eigen::VectorXd& weight);
Eigen::MatrixXd weighted_gram(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y,
                              const Eigen::VectorXd& weight);

/// A group of columns that enters a model as a whole.
struct ColumnGroup {
  Eigen::Index first = 0, count = 0;
  int family = 0;             ///< of a family, a model has at most one group
  double price = 0;           ///< of the criterion, in units of -2 log-likelihood
  double least_gain = 0;      ///< decrease of the sum of squares that makes it worth a mention
  Eigen::Index positive = 0;  ///< leading coefficients that cannot be negative
  /// Bounds of its (one) coefficient in the units of the column; 0, 0: none.
  double least = 0, most = 0;
  bool allowed = true;  ///< may enter a model
};

/// Weighted linear regression in which the set of column groups is to be chosen.
///
/// criterion(S) = n (ln s^2 + R/(n_rows s^2)) + sum of the prices, with R = RSS + sum of the least gains and
/// s^2 = max(R/n_rows, floor): twice the negative log-likelihood of n independent Gaussian errors whose
/// variance is unknown, but not below the floor. A group that lowers RSS by less than its least gain does not
/// lower R. All comparisons use one Gram matrix of the columns.
class LinearModel {
 public:
  /// @param columns  without weights
  /// @param y        rows
  /// @param weight   1/variance of each row; 0: not used
  /// @param base     columns 0 .. base - 1 are part of every model
  LinearModel(const Columns&, const Eigen::VectorXd& y, const Eigen::VectorXd& weight, Eigen::Index base);
  LinearModel(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y, const Eigen::VectorXd& weight,
              Eigen::Index base)
      : LinearModel(columns_of(columns), y, weight, base) {}

  struct Fit {
    Eigen::VectorXd coefficients;  ///< of the base, then of the groups in their order
    double rss = 0;                ///< weighted
    bool regular = true;           ///< the columns are linearly independent
  };

  using Set = std::vector<std::size_t>;

  Fit fit(const std::vector<ColumnGroup>&, const Set&) const;

  /// The set of least criterion that moves lead to: add a group, remove one, exchange one, add two of the
  /// leading ones, replace one by two; each move is the best of its round, until none improves.
  /// @param locked  the first groups of `start` that no move removes
  /// @param n       independent rows
  /// @param floor   of s^2
  /// @param seen    sets, ascending, that searches of these groups at these prices have passed; this search
  ///                ends at one of them, because its end is known
  Set search(const std::vector<ColumnGroup>&, Set start, std::size_t locked, double n, double floor,
             std::vector<Set>& seen) const;

  double criterion(const std::vector<ColumnGroup>&, const Set&, double rss, double n, double floor) const;

  /// Whether the columns are independent and every coefficient has a possible size.
  bool possible(const std::vector<ColumnGroup>&, const Set&, const Fit&) const;

  /// Smallest decrease of the weighted sum of squares that a group's coefficients of unit length cause beside
  /// a set, over all directions; 0 if the set can take the group's place.
  double least_information(const std::vector<ColumnGroup>&, const Set&, std::size_t group) const;

  /// Decrease of the residual in the principal directions of the coefficients, ascending.
  Eigen::VectorXd information(const std::vector<ColumnGroup>&, const Set&, std::size_t group) const;

  double rows() const { return rows_; }

 private:
  struct Projected;
  Eigen::MatrixXd centred_;  ///< Gram matrix of the columns about their means
  double spread_;            ///< of y about its mean, weighted sum of squares
  Projected project(const std::vector<ColumnGroup>&, const Set&, bool with_across) const;
  /// Whether a group's coefficients have a possible size.
  /// @param scaled  of its columns scaled to unit norm
  bool possible(const ColumnGroup&, const Eigen::VectorXd& scaled) const;
  /// Whether those of an added group have, and those that the set's groups then have, without a new fit: most
  /// moves that would lower the criterion are impossible.
  /// @param explained  what all added groups take of the projected solution
  bool possible_beside(const std::vector<ColumnGroup>&, const Set&, const Projected&, std::size_t added,
                       const Eigen::VectorXd& scaled, const Eigen::VectorXd& explained) const;

  double rows_, total_;
  Eigen::Index base_;
  Eigen::VectorXd scale_;
  Eigen::MatrixXd gram_;
  Eigen::VectorXd moment_;
};

}  // namespace qerr
