#include "qerr/bound/workspace.hpp"

#include <algorithm>
#include <cmath>

#include "bound/figure_column.hpp"
#include "bound/workspace_job.hpp"
#include "lanes/lanes.hpp"
#include "qerr/core/error.hpp"
#include "qerr/core/quantity.hpp"

namespace qerr {

namespace {

/// Largest |coordinate| of an independent joint over the configurations [rad or m].
double largest_coordinate(const Configurations& c, std::size_t joint) {
  if (c.method != SamplingMethod::list)
    return std::max(std::abs(c.ranges[joint].lower), std::abs(c.ranges[joint].upper));
  double largest = 0;
  for (const Eigen::VectorXd& point : c.points)
    largest = std::max(largest, std::abs(point[static_cast<Eigen::Index>(joint)]));
  return largest;
}

/// Larger angles would lose accuracy (lanes.hpp).
void require_moderate_angles(const Chain& chain, const Configurations& c) {
  for (const ChainJoint& joint : chain.joints) {
    if (joint.prismatic) continue;
    const double angle =
        std::abs(joint.multiplier) * largest_coordinate(c, joint.coordinate) + std::abs(joint.offset);
    if (!(angle <= lanes::largest_angle))
      throw Error("configurations",
                  "joint '" + joint.name + "' must stay within 2^20 rad, about 167 000 revolutions",
                  shortest(angle) + " rad", "subtract whole revolutions");
  }
}

/// Converts the results of a job to a Workspace.
class Summary {
 public:
  Summary(const WorkspaceJob& job, const OperationalModel& model, const std::vector<Norms>& filters,
          const Configurations& configurations, const WorkspaceOptions& options)
      : job_(job),
        model_(model),
        filters_(filters),
        configurations_(configurations),
        options_(options),
        figures_(job.errors().figures()),
        sums_(job.errors().sums()),
        m_(model.coordinates.size()),
        encoders_(model.transmission.encoders.size()) {}

  Workspace workspace() const {
    Workspace w;
    w.count = job_.total();
    w.exact_percentiles = job_.exact();
    for (std::size_t c = 0; c < figures_.coordinates; ++c) w.coordinates.push_back(coordinate(c));
    for (std::size_t f = 0; f < filters_.size(); ++f) w.derivatives.push_back(derivatives(f, w));
    w.mean_covariance = covariance(sums_.covariance);
    if (!options_.brief) add_details(w);
    if (sums_.pitch < sums_.count) w.smallest_cosine_of_pitch = 1 - job_.maximum(sums_.pitch);
    return w;
  }

 private:
  Statistic statistic(std::size_t figure) const {
    Statistic s = job_.statistic_of(figure);
    if (job_.total() > 0) s.at_max = draw(configurations_, job_.at_max(figure), 1).col(0);
    return s;
  }

  CoordinateStatistics coordinate(std::size_t c) const {
    CoordinateStatistics s{statistic(figures_.worst_case + c), {}, statistic(figures_.sigma + c), {}, {}};
    if (options_.brief) return s;
    s.worst_case_rigorous = statistic(figures_.rigorous + c);
    if (c >= m_) return s;  // without sums
    s.share = above(1e-24, matrix(sums_.share).row(static_cast<Eigen::Index>(c)));
    s.share_worst_case = above(1e-12, matrix(sums_.worst_share).row(static_cast<Eigen::Index>(c)));
    return s;
  }

  /// Shares that are only rounding errors of trigonometry (zeros are about 1e-17) become 0.
  static Eigen::VectorXd above(double rounding, const Eigen::VectorXd& shares) {
    return (shares.array() > rounding).select(shares, 0.0);
  }

  std::vector<DerivativeStatistics> derivatives(std::size_t f, const Workspace& w) const {
    std::vector<DerivativeStatistics> all;
    for (std::size_t c = 0; c < figures_.coordinates; ++c) {
      const std::size_t figure = f * figures_.coordinates + c;
      all.push_back({job_.errors().own_worst_case()
                         ? statistic(figures_.filtered_worst + figure)
                         : scaled(w.coordinates[c].worst_case, filters_[f].l1.upper),
                     {},
                     {},
                     {}});
      if (!sigma_is_known(model_.sources, f)) continue;
      all.back().sigma = job_.errors().own_sigma() ? statistic(figures_.filtered_sigma + figure)
                                                   : scaled(w.coordinates[c].sigma, filters_[f].h2);
      if (is_known(options_.noise_in_motion, f))
        all.back().sigma_in_motion = statistic(figures_.in_motion + figure);
    }
    return all;
  }

  void add_details(Workspace& w) const {
    w.mean_variance_parts = matrix(sums_.variance_parts);
    w.mean_quantization_parts =
        job_.errors().has_sources() ? matrix(sums_.quantization_parts) : w.mean_variance_parts;
    w.largest_arms.resize(static_cast<Eigen::Index>(encoders_));
    for (std::size_t i = 0; i < encoders_; ++i)
      w.largest_arms[static_cast<Eigen::Index>(i)] = job_.maximum(sums_.arms + i);
    if (job_.total() == 0) return;
    w.largest_at = draw(configurations_, job_.at_max(figures_.trace), 1).col(0);
    const OperationalError largest = operational_error(model_, w.largest_at);
    w.covariance_at_largest = qerr::covariance(largest);
    for (std::size_t f = 0; f < filters_.size() && job_.errors().own_sigma(); ++f) {
      auto& behind = w.filtered.emplace_back();
      if (!sigma_is_known(model_.sources, f)) continue;
      behind = {covariance(sums_.filtered + f * m_ * (m_ + 1) / 2),
                qerr::covariance(largest, filters_[f].h2, sigma_ratios(model_.sources, f, filters_[f].h2))};
    }
    if (!model_.along_motion) return;
    const auto add = [](const SignalMoments& signal, Eigen::MatrixXd& mean, Eigen::MatrixXd& at_largest) {
      mean += signal.covariance.topLeftCorner(mean.rows(), mean.cols());
      at_largest += signal.covariance.topLeftCorner(mean.rows(), mean.cols());
    };
    add(model_.along_motion->tip, w.mean_covariance, w.covariance_at_largest);
    for (std::size_t f = 0; f < w.filtered.size(); ++f)
      if (w.filtered[f].mean_covariance.size() > 0)
        add(model_.along_motion->filtered[f], w.filtered[f].mean_covariance,
            w.filtered[f].covariance_at_largest);
  }

  /// Coordinates x encoders.
  Eigen::MatrixXd matrix(std::size_t sum) const {
    Eigen::MatrixXd m(static_cast<Eigen::Index>(m_), static_cast<Eigen::Index>(encoders_));
    for (Eigen::Index c = 0; c < m.rows(); ++c)
      for (Eigen::Index i = 0; i < m.cols(); ++i) m(c, i) = job_.mean_sum(sum++);
    return m;
  }

  Eigen::MatrixXd covariance(std::size_t sum) const {
    Eigen::MatrixXd m(static_cast<Eigen::Index>(m_), static_cast<Eigen::Index>(m_));
    for (Eigen::Index r = 0; r < m.rows(); ++r)
      for (Eigen::Index c = 0; c <= r; ++c) m(r, c) = m(c, r) = job_.mean_sum(sum++);
    return m;
  }

  const WorkspaceJob& job_;
  const OperationalModel& model_;
  const std::vector<Norms>& filters_;
  const Configurations& configurations_;
  const WorkspaceOptions& options_;
  const FigureLayout& figures_;
  const SumLayout& sums_;
  std::size_t m_, encoders_;
};

}  // namespace

const Statistic* statistic_of(const Workspace& w, const Figure& f) {
  const auto pointer = [](const std::optional<Statistic>& s) { return s ? &*s : nullptr; };
  if (f.filter < 0) {
    const CoordinateStatistics& position = w.coordinates[f.signal];
    return f.bound == Bound::worst_case            ? &position.worst_case
           : f.bound == Bound::worst_case_rigorous ? &position.worst_case_rigorous
                                                   : &position.sigma;
  }
  const DerivativeStatistics& behind = w.derivatives[static_cast<std::size_t>(f.filter)][f.signal];
  return f.bound == Bound::worst_case           ? &behind.worst_case
         : f.bound == Bound::sigma              ? pointer(behind.sigma)
         : f.bound == Bound::sigma_quantization ? pointer(behind.sigma_quantization)
                                                : pointer(behind.sigma_in_motion);
}

Workspace workspace(const OperationalModel& model, const std::vector<Norms>& filters,
                    const Configurations& configurations, const WorkspaceOptions& options) {
  require_moderate_angles(model.chain, configurations);
  WorkspaceJob job(model, filters, configurations, options);
  job.run();
  return Summary(job, model, filters, configurations, options).workspace();
}

}  // namespace qerr
