#pragma once

#include <vector>

#include "bound/batched_error.hpp"
#include "control/loop_response.hpp"

namespace qerr {

/// Rows c(q) of the model's signals beside the tip's coordinates and lengths, signals x independent joints.
Eigen::MatrixXd signal_rows(const OperationalModel&, const Eigen::VectorXd& q);

/// Figures of these signals of batches of configurations: with c the derivative by each independent error,
/// sum |c| half width + |sum c mean| and sigma^2 = sum c^2 sigma^2, and the error along the motion. Behind a
/// filter half widths are multiplied by ||H||_1, means by |H(1)| and each sigma by its own ratio.
class SignalErrors {
 public:
  SignalErrors(const OperationalModel&, const ErrorFigures&, const FigureLayout&);

  /// @param q  as in BatchedError
  void operator()(const double* q, double* figures);

 private:
  /// Factors of the errors behind a filter, the first entry of `behind_` being the position.
  struct Behind {
    double l1 = 1, dc_gain = 1;
    Eigen::VectorXd variance, in_motion;  ///< [error]; empty: not known
    Eigen::VectorXd peak, along_motion;   ///< [signal]: added to the bound, and to the variance
  };
  double remainder(std::size_t signal, const Eigen::VectorXd& q) const;
  void set(std::size_t signal, const Eigen::VectorXd& q, const Eigen::VectorXd& column,
           double* figures) const;
  /// Stores the figures of a signal with norms of its own.
  void set_closed(std::size_t signal, const Eigen::VectorXd& q, const LoopsAt&, double* figures) const;

  OperationalModel model_;
  FigureLayout layout_;
  Eigen::MatrixXd moved_;  // independent joints x errors
  Eigen::VectorXd half_width_, mean_;
  Eigen::VectorXd white_, slow_;  // [error]: sigma of errors of white and of other spectra
  Eigen::VectorXd joints_;        // worst case of the independent joints
  std::vector<Behind> behind_;
  LoopsOfBatch loops_;
  bool rigorous_, own_worst_, own_sigma_;
};

}  // namespace qerr
