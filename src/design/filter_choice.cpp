#include "design/filter_choice.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "core/solve.hpp"
#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "qerr/design/requirement.hpp"
#include "qerr/filter/family.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {
std::optional<Filter> low_pass(const std::string& family, int order, double cutoff, int derivative,
                               double sample_rate) {
  for (const FilterFamily& row : filter_families()) {
    if (row.name != family) continue;
    FilterDesign d;
    d.derivative = derivative;
    d.sample_rate = sample_rate;
    for (const Parameter& p : row.parameters) {
      if (p.kind == Kind::choice) d.choices[std::string(p.name)] = choices_of(p).front();
      if (p.fallback) d.numbers[std::string(p.name)] = *p.fallback;
    }
    d.numbers["order"] = order;
    d.numbers["cutoff"] = cutoff;
    try {
      return row.design(d);
    } catch (const Error& e) {
      if (e.trouble() != Trouble::input) throw;
      return std::nullopt;
    }
  }
  return std::nullopt;
}

double tracking_up_to(const Filter& filter, double band) {
  return band_tracking(filter, 1e-4 * band, band).largest;
}

namespace {

/// The largest tracking error at equally spaced frequencies: a quick lower bound of that of the band.
double sampled_tracking(const Filter& filter, double band) {
  constexpr int samples = 24;
  double largest = 0;
  for (int i = samples; i > 0; --i)
    largest = std::max(largest, fidelity(filter, band * i / samples).tracking_error);
  return largest;
}

/// The scan of one family and order.
class CutoffScan {
 public:
  CutoffScan(const FilterRange& range, int derivative, double sample_rate,
             const std::function<bool(const Filter&)>& accepts, const std::string& family, int order,
             FilterScan& to)
      : range_(range),
        derivative_(derivative),
        sample_rate_(sample_rate),
        accepts_(accepts),
        family_(family),
        order_(order),
        to_(to) {}

  void run() {
    const double octaves = std::log2(range_.most_cutoff / range_.least_cutoff);
    const int steps = octaves > 0 ? std::max(24, static_cast<int>(std::ceil(12 * octaves))) : 0;
    std::optional<double> before;
    bool before_met = false;
    for (int i = 0; i <= steps; ++i) {
      const double cutoff =
          i == steps ? range_.most_cutoff : range_.least_cutoff * std::exp2(octaves * i / std::max(steps, 1));
      const std::optional<Filter> filter = at(cutoff);
      if (!filter) continue;
      ++to_.filters;
      to_.any_true_gain = to_.any_true_gain || passes_slow_motion(*filter);
      to_.least_delay = std::min(to_.least_delay, group_delay(*filter));
      if (range_.tracking)
        to_.least_tracking = std::min(to_.least_tracking, sampled_tracking(*filter, range_.tracking->band));
      const bool met = meets(*filter);
      if (before && met != before_met) add(met ? end_between(*before, cutoff) : end_between(cutoff, *before));
      if (met) add(cutoff);
      before = cutoff;
      before_met = met;
    }
  }

 private:
  std::optional<Filter> at(double cutoff) const {
    return low_pass(family_, order_, cutoff, derivative_, sample_rate_);
  }

  bool meets(const Filter& filter) const {
    if (!range_.tracking && !passes_slow_motion(filter)) return false;
    if (range_.delay && !(group_delay(filter) <= *range_.delay)) return false;
    if (range_.tracking && !(sampled_tracking(filter, range_.tracking->band) <= range_.tracking->at_most))
      return false;
    return accepts_(filter);
  }

  bool meets(double cutoff) const {
    const std::optional<Filter> filter = at(cutoff);
    return filter && meets(*filter);
  }

  /// The cut-off between one that is beyond a limit and one within, nearest to the former, to six digits.
  double end_between(double beyond, double within) const {
    for (int i = 0; i < 40 && std::abs(within - beyond) > 1e-8 * within; ++i) {
      const double middle = std::sqrt(beyond * within);
      (meets(middle) ? within : beyond) = middle;
    }
    const double unit = std::pow(10.0, std::floor(std::log10(within)) - 5);
    const double rounded = (within > beyond ? std::ceil(within / unit) : std::floor(within / unit)) * unit;
    const double neat = rounded_to(rounded, 6);
    return neat >= range_.least_cutoff && neat <= range_.most_cutoff && meets(neat) ? neat : within;
  }

  void add(double cutoff) {
    const std::optional<Filter> filter = at(cutoff);
    if (!filter) return;
    FilterCandidate c{family_, order_, cutoff, *filter, h2_norm(*filter), group_delay(*filter), {}};
    if (!std::isfinite(c.h2)) return;
    if (range_.tracking) {
      c.tracking = tracking_up_to(*filter, range_.tracking->band);
      if (!(*c.tracking <= range_.tracking->at_most)) return;  // a peak between the samples
    }
    to_.candidates.push_back(std::move(c));
  }

  const FilterRange& range_;
  int derivative_;
  double sample_rate_;
  const std::function<bool(const Filter&)>& accepts_;
  const std::string& family_;
  int order_;
  FilterScan& to_;
};

Dimension per_sample_power(const Filter& f) {
  Dimension d;
  d.second = -f.derivative;
  return d;
}
Dimension of_time(const Filter&) { return dimension::time; }
Dimension of_frequency(const Filter&) { return dimension::frequency; }

constexpr FilterFigure figures[] = {
    {"h2_norm", "sigma of the output for white input of unit sigma", per_sample_power,
     [](const Filter&, const Norms& n) -> std::optional<double> { return n.h2; }, true},
    {"l1_norm", "peak of the output for input bounded by 1", per_sample_power,
     [](const Filter&, const Norms& n) -> std::optional<double> { return n.l1.upper; }, true},
    {"delay", "group delay at 0 Hz", of_time,
     [](const Filter& f, const Norms&) -> std::optional<double> { return group_delay(f); }},
    {"bandwidth", "frequency at which the estimate falls to 1/sqrt(2)", of_frequency,
     [](const Filter& f, const Norms&) { return bandwidth(f); }},
    {"settling", "until the step response stays within 2 %", of_time,
     [](const Filter& f, const Norms&) { return settling_time(f); }},
};

/// min |y|^2/2 subject to rows y <= bounds, by its dual; rows are added as they are found to be violated.
class LeastNorm {
 public:
  explicit LeastNorm(Eigen::Index size) : y_(Eigen::VectorXd::Zero(size)) {}

  void add(Eigen::VectorXd row, double bound) {
    const Eigen::Index n = size();
    Eigen::MatrixXd gram(n + 1, n + 1);
    gram.topLeftCorner(n, n) = gram_;
    for (Eigen::Index i = 0; i < n; ++i) gram(i, n) = gram(n, i) = rows_[i].dot(row);
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
      if (passive(r)) y_ -= multiplier(r) * rows_[r];
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
  Eigen::Index size() const { return std::ssize(rows_); }
  double& multiplier(Eigen::Index r) { return multipliers_[r]; }
  double multiplier(Eigen::Index r) const { return multipliers_[r]; }
  double bound(Eigen::Index r) const { return bounds_[r]; }
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
      const auto n = std::ssize(set);
      Eigen::MatrixXd g = gram_(set, set);
      Eigen::VectorXd b(n);
      for (Eigen::Index i = 0; i < n; ++i) b[i] = -bound(set[i]);
      g.diagonal() *= 1 + 1e-13;  // neighbouring frequencies make it nearly singular
      const Eigen::VectorXd wanted = solve_symmetric(g, b);
      double step = 1;
      for (Eigen::Index i = 0; i < n; ++i) {
        const double now = multiplier(set[i]);
        if (!(wanted[i] > 0)) step = std::min(step, now / (now - wanted[i]));
      }
      bool left = false;
      for (Eigen::Index i = 0; i < n; ++i) {
        double& m = multiplier(set[i]);
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
  explicit Tracking(const FirTask& task) : n_(task.taps), derivative_(task.derivative) {
    const double end = 2 * std::numbers::pi * task.band / task.sample_rate;
    // A response of n taps bends on the scale 2 pi/n.
    const auto count =
        static_cast<int>(std::ceil(8 * end * static_cast<double>(n_) / (2 * std::numbers::pi))) + 24;
    for (int i = 1; i <= count; ++i) frequencies_.push_back(end * i / count);
    Eigen::MatrixXd moments(n_, derivative_ + 1);
    for (Eigen::Index k = 0; k < n_; ++k)
      for (int m = 0; m <= derivative_; ++m)
        moments(k, m) = std::pow(2 * static_cast<double>(k) / static_cast<double>(n_) - 1, m);
    moments_ = orthonormal_basis(moments);
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

FilterScan filter_candidates(const FilterRange& range, int derivative, double sample_rate,
                             const std::function<bool(const Filter&)>& accepts) {
  FilterScan scan;
  scan.least_delay = scan.least_tracking = std::numeric_limits<double>::infinity();
  for (const std::string& family : range.families)
    for (const int order : range.orders)
      CutoffScan(range, derivative, sample_rate, accepts, family, order, scan).run();
  return scan;
}

std::span<const FilterFigure> filter_figures() { return figures; }

const FilterFigure* find_filter_figure(std::string_view name) {
  const auto row = std::find_if(std::begin(figures), std::end(figures),
                                [&](const FilterFigure& f) { return f.name == name; });
  return row == std::end(figures) ? nullptr : row;
}

std::string figure_unit(const FilterFigure& figure, const Filter& filter) {
  if (!figure.norm) return unit_name(figure.dimension(filter));
  return filter.derivative == 0   ? ""
         : filter.derivative == 1 ? "1/s"
                                  : "1/s^" + std::to_string(filter.derivative);  // no frequency
}

QuietestFir quietest_fir(const FirTask& task) {
  constexpr int most_rounds = 80;
  constexpr double tolerance = 1e-3;  // of the tracking error
  const Tracking tracking(task);
  LeastNorm programme(task.taps);
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
