#include "qerr/bound/workspace.hpp"

#include <cmath>

#include "qerr/core/parallel.hpp"

namespace qerr {

namespace {

constexpr std::uint64_t block_size = 512;
constexpr std::uint64_t blocks_per_wave = 128;

/// Sums over some configurations; partial ones are appended in the order of the configurations.
struct Sums {
  std::vector<Accumulator> worst, rigorous, sigma;  // [coordinate]
  std::vector<std::vector<Accumulator>>
      filtered_worst;  // [filter][coordinate]; only where a mean error or a source exists
  std::vector<std::vector<Accumulator>> filtered_sigma;  // the same; only where a source exists
  std::vector<std::vector<Accumulator>> in_motion;  // [filter][coordinate]; only where the noise is known
  Eigen::MatrixXd share, share_worst, variance_parts, covariance, covariance_at_largest;
  std::vector<Eigen::MatrixXd> filtered_covariance;  // [filter]; only where a source exists
  Eigen::VectorXd largest_at;
  double largest_trace = -1, largest_arm = 0, smallest_cosine = 1;

  /// How many filters need figures of their own.
  struct Filters {
    std::size_t worst = 0, sigma = 0, moving = 0;
  };

  Sums(std::size_t coordinates, std::size_t encoders, const Filters& filters, std::uint64_t expected)
      : worst(coordinates, Accumulator(expected)),
        rigorous(worst),
        sigma(worst),
        filtered_worst(filters.worst, worst),
        filtered_sigma(filters.sigma, worst),
        in_motion(filters.moving, worst),
        share(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(coordinates),
                                    static_cast<Eigen::Index>(encoders))),
        share_worst(share),
        variance_parts(share),
        covariance(Eigen::MatrixXd::Zero(share.rows(), share.rows())),
        covariance_at_largest(covariance),
        filtered_covariance(filters.sigma, covariance) {}

  void append(const Sums& later) {
    for (std::size_t i = 0; i < worst.size(); ++i) {
      worst[i].append(later.worst[i]);
      rigorous[i].append(later.rigorous[i]);
      sigma[i].append(later.sigma[i]);
      for (std::size_t f = 0; f < filtered_worst.size(); ++f)
        filtered_worst[f][i].append(later.filtered_worst[f][i]);
      for (std::size_t f = 0; f < filtered_sigma.size(); ++f)
        filtered_sigma[f][i].append(later.filtered_sigma[f][i]);
      for (std::size_t f = 0; f < in_motion.size(); ++f) in_motion[f][i].append(later.in_motion[f][i]);
    }
    share += later.share;
    share_worst += later.share_worst;
    variance_parts += later.variance_parts;
    covariance += later.covariance;
    for (std::size_t f = 0; f < filtered_covariance.size(); ++f)
      filtered_covariance[f] += later.filtered_covariance[f];
    largest_arm = std::max(largest_arm, later.largest_arm);
    smallest_cosine = std::min(smallest_cosine, later.smallest_cosine);
    if (later.largest_trace > largest_trace) {
      largest_trace = later.largest_trace;
      largest_at = later.largest_at;
      covariance_at_largest = later.covariance_at_largest;
    }
  }
};

/// Parts of each row's sum, of the squares and of the parts of the worst case; entries that are nothing but
/// rounding against the largest row count as zero.
///
/// A zero comes out of trigonometry as 1e-17, and shares of such noise would look like figures.
void add_shares(const Eigen::MatrixXd& spread, const Eigen::MatrixXd& worst, double negligible, Sums& sums) {
  const auto cleaned = [&](const Eigen::MatrixXd& m) {
    return (m.cwiseAbs().array() > negligible).select(m.cwiseAbs(), 0.0).eval();
  };
  const auto of_variance = cleaned(spread), of_worst = cleaned(worst);
  for (Eigen::Index i = 0; i < spread.rows(); ++i) {
    const double total = of_worst.row(i).sum(), squares = of_variance.row(i).squaredNorm();
    if (!std::isfinite(total) || total == 0) continue;
    if (squares > 0) sums.share.row(i) += of_variance.row(i).cwiseAbs2() / squares;
    sums.share_worst.row(i) += of_worst.row(i) / total;
  }
}

class Job {
 public:
  Job(const OperationalModel& model, const std::vector<Norms>& filters,
      const std::vector<Eigen::VectorXd>& noise_in_motion)
      : model_(model), filters_(filters), noise_(noise_in_motion), delta_(resolutions(model.transmission)) {
    has_sources_ = !model.sources.empty();
    own_worst_case_ = has_sources_ || !mean_errors(model.transmission).isZero(0);
    for (std::size_t f = 0; f < filters.size(); ++f)
      gains_.push_back(gains_behind(model.sources, f, filters[f].h2));
  }

  Sums empty(std::uint64_t expected) const {
    return Sums(model_.coordinates.size(), model_.transmission.encoders.size(),
                {own_worst_case_ ? filters_.size() : 0, has_sources_ ? filters_.size() : 0, noise_.size()},
                expected);
  }

  bool own_worst_case() const { return own_worst_case_; }
  bool has_sources() const { return has_sources_; }
  const Eigen::VectorXd& gains(std::size_t filter) const { return gains_[filter]; }

  void block(const Eigen::MatrixXd& points, std::vector<OperationalError>& errors, Sums& sums) const {
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const Eigen::VectorXd q = points.col(i);
      errors.push_back(operational_error(model_, q));
      add(errors.back(), q, sums);
    }
  }

 private:
  void add(const OperationalError& e, const Eigen::VectorXd& q, Sums& sums) const {
    for (std::size_t i = 0; i < model_.coordinates.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      sums.worst[i].add(e.worst_case[row], q);
      sums.rigorous[i].add(e.rigorous[row], q);
      sums.sigma[i].add(e.sigma[row], q);
      for (std::size_t f = 0; f < sums.filtered_worst.size(); ++f)
        sums.filtered_worst[f][i].add(derivative_error(e, row, filters_[f], gains_[f]).worst_case, q);
      for (std::size_t f = 0; f < sums.filtered_sigma.size(); ++f)
        sums.filtered_sigma[f][i].add(derivative_error(e, row, filters_[f], gains_[f]).sigma, q);
      for (std::size_t f = 0; f < noise_.size(); ++f)
        if (is_known(noise_, f)) sums.in_motion[f][i].add(sigma_in_motion(e, row, noise_[f], gains_[f]), q);
      if (is_position(model_.coordinates[i]))
        sums.largest_arm = std::max(
            sums.largest_arm, e.weighted.row(row).cwiseAbs().cwiseQuotient(delta_.transpose()).maxCoeff());
    }
    double scale = 0;
    for (Eigen::Index i = 0; i < e.weighted.rows(); ++i)
      if (const double norm = e.weighted.row(i).norm(); std::isfinite(norm)) scale = std::max(scale, norm);
    const Eigen::MatrixXd spread = has_sources_ ? by_encoder(e) : e.weighted;
    add_shares(spread, has_sources_ ? worst_by_encoder(e) : e.weighted, 1e-13 * scale, sums);
    sums.smallest_cosine = std::min(sums.smallest_cosine, e.cosine_of_pitch);
    const Eigen::MatrixXd covariance = qerr::covariance(e);
    sums.variance_parts += spread.cwiseAbs2() / 12.0;
    for (std::size_t f = 0; f < sums.filtered_covariance.size(); ++f)
      sums.filtered_covariance[f] += qerr::covariance(e, filters_[f].h2, gains_[f]);
    sums.covariance += covariance;
    if (const double trace = size_of(covariance); trace > sums.largest_trace) {
      sums.largest_trace = trace;
      sums.largest_at = q;
      sums.covariance_at_largest = covariance;
    }
  }

  /// What each encoder weighs with the sources of it and its joint, in the units of `weighted`.
  Eigen::MatrixXd by_encoder(const OperationalError& e) const {
    Eigen::MatrixXd squares = e.weighted.cwiseAbs2();
    for (Eigen::Index s = 0; s < e.added_sigma.cols(); ++s)
      squares.col(owner(s)) += 12 * e.added_sigma.col(s).cwiseAbs2();
    return squares.cwiseSqrt();
  }

  Eigen::MatrixXd worst_by_encoder(const OperationalError& e) const {
    Eigen::MatrixXd worst = e.weighted.cwiseAbs();
    for (Eigen::Index s = 0; s < e.added_worst.cols(); ++s) worst.col(owner(s)) += 2 * e.added_worst.col(s);
    return worst;
  }

  Eigen::Index owner(Eigen::Index source) const {
    return static_cast<Eigen::Index>(model_.sources[static_cast<std::size_t>(source)].owner);
  }

  /// Trace over the positions alone, as metres and radians do not add; over all coordinates where there is no
  /// position.
  double size_of(const Eigen::MatrixXd& covariance) const {
    double positions = 0;
    bool any = false;
    for (std::size_t i = 0; i < model_.coordinates.size(); ++i)
      if (is_position(model_.coordinates[i])) {
        positions += covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
        any = true;
      }
    return any ? positions : covariance.trace();
  }

  const OperationalModel& model_;
  const std::vector<Norms>& filters_;
  const std::vector<Eigen::VectorXd>& noise_;
  Eigen::VectorXd delta_;
  std::vector<Eigen::VectorXd> gains_;
  bool has_sources_ = false;
  bool own_worst_case_ = false;  // not the position's times ||H||_1
};

Workspace finish(const OperationalModel& model, const std::vector<Norms>& filters,
                 const WorkspaceOptions& options, const Job& job, const Sums& sums, std::uint64_t count) {
  Workspace w;
  w.count = count;
  w.exact_percentiles = sums.sigma.empty() || sums.sigma.front().percentiles_are_exact();
  const double n = static_cast<double>(std::max<std::uint64_t>(count, 1));
  for (std::size_t i = 0; i < model.coordinates.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    w.coordinates.push_back({sums.worst[i].result(), sums.rigorous[i].result(), sums.sigma[i].result(),
                             sums.share.row(row).transpose() / n, sums.share_worst.row(row).transpose() / n});
  }
  for (std::size_t f = 0; f < filters.size(); ++f) {
    std::vector<DerivativeStatistics>& of_filter = w.derivatives.emplace_back();
    for (std::size_t i = 0; i < model.coordinates.size(); ++i) {
      of_filter.push_back({job.own_worst_case() ? sums.filtered_worst[f][i].result()
                                                : scaled(w.coordinates[i].worst_case, filters[f].l1.upper),
                           job.has_sources() ? sums.filtered_sigma[f][i].result()
                                             : scaled(w.coordinates[i].sigma, filters[f].h2),
                           {}});
      if (is_known(options.noise_in_motion, f))
        of_filter.back().sigma_in_motion = sums.in_motion[f][i].result();
    }
  }
  w.mean_variance_parts = sums.variance_parts / n;
  w.mean_covariance = sums.covariance / n;
  w.covariance_at_largest = sums.covariance_at_largest;
  w.largest_at = sums.largest_at;
  w.largest_arm = sums.largest_arm;
  w.smallest_cosine_of_pitch = sums.smallest_cosine;
  if (!job.has_sources() || sums.largest_at.size() == 0) return w;
  const OperationalError largest = operational_error(model, sums.largest_at);
  for (std::size_t f = 0; f < filters.size(); ++f)
    w.filtered.push_back({sums.filtered_covariance[f] / n, covariance(largest, filters[f].h2, job.gains(f))});
  return w;
}

}  // namespace

double sigma_in_motion(const OperationalError& e, Eigen::Index coordinate, const Eigen::VectorXd& noise,
                       const Eigen::VectorXd& gains) {
  const double quantization = e.weighted.row(coordinate).cwiseProduct(noise.transpose()).norm();
  if (gains.size() == 0 || !std::isfinite(quantization)) return quantization;
  return std::hypot(quantization, e.added_sigma.row(coordinate).cwiseProduct(gains.transpose()).norm());
}

Statistic scaled(const Statistic& s, double factor) {
  return {s.min * factor, s.mean * factor, s.max * factor, s.p50 * factor,
          s.p95 * factor, s.p99 * factor,  s.at_max};
}

Workspace workspace(const OperationalModel& model, const std::vector<Norms>& filters,
                    const Configurations& configurations, const WorkspaceOptions& options) {
  const Job job(model, filters, options.noise_in_motion);
  const std::uint64_t total = size(configurations);
  Sums sums = job.empty(total);
  for (std::uint64_t wave = 0; wave < total; wave += block_size * blocks_per_wave) {
    const std::uint64_t in_wave = std::min(block_size * blocks_per_wave, total - wave);
    const auto blocks = static_cast<std::size_t>((in_wave + block_size - 1) / block_size);
    std::vector<Sums> partial(blocks, job.empty(0));
    std::vector<Eigen::MatrixXd> points(blocks);
    std::vector<std::vector<OperationalError>> errors(blocks);
    parallel_for(blocks, options.threads, [&](std::size_t b) {
      const std::uint64_t first = wave + b * block_size;
      points[b] = draw(configurations, first, std::min(block_size, total - first));
      job.block(points[b], errors[b], partial[b]);
      if (!options.visit) errors[b].clear();
    });
    for (std::size_t b = 0; b < blocks; ++b) {
      sums.append(partial[b]);
      if (options.visit) options.visit(wave + b * block_size, points[b], errors[b]);
    }
    if (options.progress) options.progress(wave + in_wave, total);
  }
  return finish(model, filters, options, job, sums, total);
}

}  // namespace qerr
