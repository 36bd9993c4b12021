#include "design/quietest_fir.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace qerr {

namespace {

/// min |y|^2/2 subject to rows y <= bounds, by its dual; rows are added as they are found to be violated.
class LeastNorm {
 public:
  explicit LeastNorm(Eigen::Index size) : y_(Eigen::VectorXd::Zero(size)) {}

  void add(Eigen::VectorXd row, double bound) {
    const Eigen::Index n = size();
    Eigen::MatrixXd gram(n + 1, n + 1);
    gram.topLeftCorner(n, n) = gram_;
    for (Eigen::Index i = 0; i < n; ++i)
      gram(i, n) = gram(n, i) = rows_[static_cast<std::size_t>(i)].dot(row);
    gram(n, n) = row.squaredNorm();
    gram_ = std::move(gram);
    rows_.push_back(std::move(row));
    bounds_.push_back(bound);
    multipliers_.push_back(0);
  }

  /// Solves for the present rows, from the multipliers of the last solution.
  void solve() {
    const int most = 20 * static_cast<int>(size()) + 100;
    for (int i = 0; i < most; ++i) {
      Eigen::Index worst = -1;
      double violation = 1e-9;
      for (Eigen::Index r = 0; r < size(); ++r) {
        const double v = (gram_row(r) + bound(r)) / -std::sqrt(gram_(r, r));
        if (!passive(r) && v > violation) {
          violation = v;
          worst = r;
        }
      }
      if (worst < 0 && i > 0) break;
      if (worst >= 0) multiplier(worst) = std::numeric_limits<double>::min();  // joins the passive set
      settle_passive();
    }
    y_.setZero();
    for (Eigen::Index r = 0; r < size(); ++r)
      if (passive(r)) y_ -= multiplier(r) * rows_[static_cast<std::size_t>(r)];
  }

  /// Forgets rows whose multipliers are 0.
  void drop_idle() {
    std::vector<Eigen::VectorXd> rows;
    std::vector<double> bounds, multipliers;
    std::vector<Eigen::Index> kept;
    for (Eigen::Index r = 0; r < size(); ++r) {
      if (!passive(r)) continue;
      const auto i = static_cast<std::size_t>(r);
      rows.push_back(std::move(rows_[i]));
      bounds.push_back(bounds_[i]);
      multipliers.push_back(multipliers_[i]);
      kept.push_back(r);
    }
    gram_ = Eigen::MatrixXd(gram_(kept, kept));
    rows_ = std::move(rows);
    bounds_ = std::move(bounds);
    multipliers_ = std::move(multipliers);
  }

  const Eigen::VectorXd& y() const { return y_; }

  /// Lower bound of |y|^2/2 over all y within the rows: -|A^T l|^2/2 - b^T l.
  double dual_value() const {
    double value = -0.5 * y_.squaredNorm();
    for (std::size_t r = 0; r < bounds_.size(); ++r) value -= bounds_[r] * multipliers_[r];
    return value;
  }

 private:
  Eigen::Index size() const { return static_cast<Eigen::Index>(rows_.size()); }
  double& multiplier(Eigen::Index r) { return multipliers_[static_cast<std::size_t>(r)]; }
  double multiplier(Eigen::Index r) const { return multipliers_[static_cast<std::size_t>(r)]; }
  double bound(Eigen::Index r) const { return bounds_[static_cast<std::size_t>(r)]; }
  bool passive(Eigen::Index r) const { return multiplier(r) > 0; }
  double gram_row(Eigen::Index r) const {
    double sum = 0;
    for (Eigen::Index k = 0; k < size(); ++k)
      if (passive(k)) sum += gram_(r, k) * multiplier(k);
    return sum;
  }

  /// The multipliers of the passive rows, which meet their bounds exactly; rows whose multiplier would become
  /// negative leave.
  void settle_passive() {
    while (true) {
      std::vector<Eigen::Index> set;
      for (Eigen::Index r = 0; r < size(); ++r)
        if (passive(r)) set.push_back(r);
      if (set.empty()) return;
      const auto n = static_cast<Eigen::Index>(set.size());
      Eigen::MatrixXd g = gram_(set, set);
      Eigen::VectorXd b(n);
      for (Eigen::Index i = 0; i < n; ++i) b[i] = -bound(set[static_cast<std::size_t>(i)]);
      g.diagonal() *= 1 + 1e-13;  // neighbouring frequencies make it nearly singular
      const Eigen::VectorXd wanted = g.ldlt().solve(b);
      double step = 1;
      for (Eigen::Index i = 0; i < n; ++i) {
        const double now = multiplier(set[static_cast<std::size_t>(i)]);
        if (!(wanted[i] > 0)) step = std::min(step, now / (now - wanted[i]));
      }
      bool left = false;
      for (Eigen::Index i = 0; i < n; ++i) {
        double& m = multiplier(set[static_cast<std::size_t>(i)]);
        m += step * (wanted[i] - m);
        if (!(wanted[i] > 0) && m <= 1e-14 * std::abs(wanted[i]) + std::numeric_limits<double>::min()) {
          m = 0;
          left = true;
        }
      }
      if (!left) return;
    }
  }

  Eigen::MatrixXd gram_;
  std::vector<Eigen::VectorXd> rows_;
  std::vector<double> bounds_, multipliers_;
  Eigen::VectorXd y_;
};

/// The tracking error of taps at angular frequencies per sample, and the gradients of its parts. Taps are in
/// units of sample_rate^d; they differ from `least()` by what is orthogonal to the first d + 1 moments.
class Tracking {
 public:
  explicit Tracking(const FirTask& task)
      : n_(static_cast<Eigen::Index>(task.taps)), derivative_(task.derivative) {
    const double end = 2 * std::numbers::pi * task.band / task.sample_rate;
    // A response of n taps bends on the scale 2 pi/n.
    const auto count =
        static_cast<int>(std::ceil(8 * end * static_cast<double>(n_) / (2 * std::numbers::pi))) + 24;
    for (int i = 1; i <= count; ++i) frequencies_.push_back(end * i / count);
    Eigen::MatrixXd moments(n_, derivative_ + 1);
    for (Eigen::Index k = 0; k < n_; ++k)
      for (int m = 0; m <= derivative_; ++m)
        moments(k, m) = std::pow(2 * static_cast<double>(k) / static_cast<double>(n_) - 1, m);
    moments_ = Eigen::HouseholderQR<Eigen::MatrixXd>(moments).householderQ() *
               Eigen::MatrixXd::Identity(n_, derivative_ + 1);
    double of_last = 0;  // the gain of slow motion of the last basis vector: sum (-k)^d/d! h_k
    for (Eigen::Index k = 0; k < n_; ++k)
      of_last += std::pow(-static_cast<double>(k), derivative_) / std::tgamma(derivative_ + 1) *
                 moments_(k, derivative_);
    least_ = task.gain / of_last * moments_.col(derivative_);
  }

  /// The taps of least norm with the gain of slow motion, orthogonal to all differences from them.
  const Eigen::VectorXd& least() const { return least_; }

  const std::vector<double>& frequencies() const { return frequencies_; }

  std::complex<double> error(const Eigen::VectorXd& h, double w) const {
    // Horner's rule in e^{-jw}.
    const std::complex<double> z = std::polar(1.0, -w);
    std::complex<double> sum = 0;
    for (Eigen::Index k = n_; k-- > 0;) sum = sum * z + h[k];
    return sum / std::pow(std::complex<double>(0, w), derivative_) - 1.0;
  }

  /// The gradient of Re e^{-j phi} (error + 1), within the subspace.
  Eigen::VectorXd row(double w, double phi) const {
    const std::complex<double> factor =
        std::polar(1.0, -phi) / std::pow(std::complex<double>(0, w), derivative_);
    Eigen::VectorXd a(n_);
    for (Eigen::Index k = 0; k < n_; ++k)
      a[k] = (factor * std::polar(1.0, -w * static_cast<double>(k))).real();
    for (int twice = 0; twice < 2; ++twice) a -= moments_ * (moments_.transpose() * a);
    return a;
  }

 private:
  Eigen::Index n_;
  int derivative_;
  std::vector<double> frequencies_;
  Eigen::MatrixXd moments_;
  Eigen::VectorXd least_;
};

}  // namespace

QuietestFir quietest_fir(const FirTask& task) {
  constexpr int most_rounds = 80;
  constexpr double tolerance = 1e-3;  // of the tracking error
  const Tracking tracking(task);
  LeastNorm programme(static_cast<Eigen::Index>(task.taps));
  const std::vector<double>& w = tracking.frequencies();
  QuietestFir best;
  const double scale = std::pow(task.sample_rate, task.derivative);
  for (int round = 0; round < most_rounds && !best.converged; ++round) {
    std::vector<std::complex<double>> errors;
    for (const double frequency : w)
      errors.push_back(tracking.error(tracking.least() + programme.y(), frequency));
    best.tracking = 0;
    for (const auto& e : errors) best.tracking = std::max(best.tracking, std::abs(e));
    best.converged = best.tracking <= task.tracking * (1 + tolerance);
    if (best.converged) break;
    programme.drop_idle();
    for (std::size_t i = 0; i < w.size(); ++i) {
      const double here = std::abs(errors[i]);
      const bool peak = (i == 0 || here >= std::abs(errors[i - 1])) &&
                        (i + 1 == w.size() || here >= std::abs(errors[i + 1]));
      if (!peak || here <= task.tracking * (1 + 0.5 * tolerance)) continue;
      const double phi = std::arg(errors[i]);
      const std::complex<double> of_least = tracking.error(tracking.least(), w[i]);
      programme.add(tracking.row(w[i], phi), task.tracking - (std::polar(1.0, -phi) * of_least).real());
    }
    programme.solve();
  }
  const Eigen::VectorXd h = scale * (tracking.least() + programme.y());
  best.h.assign(h.data(), h.data() + h.size());
  best.h2 = h.norm();
  best.h2_bound =
      scale * std::sqrt(tracking.least().squaredNorm() + 2 * std::max(0.0, programme.dual_value()));
  return best;
}

}  // namespace qerr
