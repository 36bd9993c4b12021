#include "diagnose/surrogates/residual_sums.hpp"

#include <algorithm>
#include <cmath>

#include "lanes/select_kernels.hpp"

namespace qerr {

namespace {

constexpr std::size_t smooth = 16;  ///< readings per mean, in autocorrelation_smooth
static_assert(ResidualSums::most_rows % smooth == 0);

Eigen::Map<const Eigen::ArrayXXd> by_lane(const AlignedNumbers& a, std::size_t width) {
  return {a.data(), static_cast<Eigen::Index>(width), static_cast<Eigen::Index>(a.size() / width)};
}

}  // namespace

Moments::Moments(std::size_t width, const ResidualKernels& kernels)
    : kernels_(&kernels),
      width_(width),
      sum_(width),
      square_(width),
      lagged_(width),
      last_(width),
      firsts_(width),
      lasts_(width) {}

void Moments::start() {
  for (std::size_t i = 0; i < width_; ++i) lasts_[i] += last_[i], last_[i] = 0;
  begins_ = true;
}

void Moments::add(const double* in, std::size_t rows) {
  if (rows == 0) return;
  for (std::size_t i = 0; begins_ && i < width_; ++i) firsts_[i] += in[i];
  begins_ = false;
  kernels_->moments(in, rows, width_, {sum_.data(), square_.data(), lagged_.data(), last_.data()});
  rows_ += rows;
}

Eigen::ArrayXd Moments::of(const AlignedNumbers& a) {
  return Eigen::Map<const Eigen::ArrayXd>(a.data(), static_cast<Eigen::Index>(a.size()));
}

Eigen::ArrayXd Moments::correlation(double ranges) const {
  const double pairs = rows() - ranges;
  // Means of all left and of all right neighbours: without the last and without the first values.
  const Eigen::ArrayXd left = (of(sum_) - (of(lasts_) + of(last_))) / pairs,
                       right = (of(sum_) - of(firsts_)) / pairs;
  return (of(lagged_) / pairs - left * right) / variance().max(1e-6);
}

ResidualSums::ResidualSums(const ResidualPlan& plan, std::size_t width, InstructionSet set)
    : plan_(plan),
      kernels_(select_kernels<ResidualKernels>(set)),
      width_(width),
      moments_(width, kernels_),
      smooth_(width, kernels_),
      places_(most_rows * width),
      bins_(width * residual_bins),
      by_state_(4 * width),
      in_state_(4 * width),
      scratch_(most_rows * width) {
  for (const FilteredResidual& v : plan.velocities) {
    velocities_.emplace_back(width, kernels_);
    filters_.emplace_back(*v.filter, width, most_rows, set);
  }
  for (const Projection& p : plan.projections)
    projected_.emplace_back(width * static_cast<std::size_t>(p.columns.cols()));
}

void ResidualSums::start() {
  moments_.start();
  smooth_.start();
  for (RowFilter& f : filters_) f.reset();
  in_range_ = 0;
}

void ResidualSums::add(const double* r, const double* state, std::size_t rows) {
  moments_.add(r, rows);
  kernels_.means(r, rows, smooth, width_, scratch_.data());
  smooth_.add(scratch_.data(), rows / smooth);
  for (std::size_t p = 0; p < projected_.size(); ++p)
    for (Eigen::Index c = 0; c < plan_.projections[p].columns.cols(); ++c)
      kernels_.project(plan_.projections[p].columns.col(c).data() + row_, r, rows, width_,
                       projected_[p].data() + static_cast<std::size_t>(c) * width_);
  const double middle = plan_.e->encoder.rounding == Rounding::down ? -0.5 : 0.0;
  kernels_.distribute(r, middle, rows, width_, places_.data(), bins_.data());
  kernels_.by_state(r, state, rows, width_, by_state_.data(), in_state_.data());
  add_velocities(r, rows);
  row_ += rows;
  in_range_ += rows;
}

void ResidualSums::add_velocities(const double* r, std::size_t rows) {
  for (std::size_t f = 0; f < filters_.size(); ++f) {
    filters_[f](r, width_, rows, scratch_.data());
    const auto settling = static_cast<std::size_t>(plan_.velocities[f].settling);
    const std::size_t transient = std::min(rows, settling - std::min(settling, in_range_));
    velocities_[f].add(scratch_.data() + transient * width_, rows - transient);
  }
}

Eigen::ArrayXd ResidualSums::distance_from_uniform() const {
  Eigen::ArrayXd distance(static_cast<Eigen::Index>(width_));
  for (std::size_t i = 0; i < width_; ++i) {
    double below = 0, largest = 0;
    for (int b = 0; b < residual_bins; ++b) {
      below += bins_[i * residual_bins + static_cast<std::size_t>(b)];
      const double uniform = std::clamp((b + 1) / (0.5 * residual_bins) - 0.5, 0.0, 1.0);
      largest = std::max(largest, std::abs(below / moments_.rows() - uniform));
    }
    distance[static_cast<Eigen::Index>(i)] = largest;
  }
  return distance;
}

void ResidualSums::add_correlations(std::vector<ResidualStatistic>& all) const {
  const auto ranges = static_cast<double>(plan_.ranges.size());
  all.push_back({"autocorrelation", Tail::both_sides, 1, 0.01, moments_.correlation(ranges)});
  if (smooth_.rows() > 24 + ranges)
    all.push_back({"autocorrelation_smooth", Tail::both_sides, 1, 0.1, smooth_.correlation(ranges)});
}

void ResidualSums::add_projections(std::vector<ResidualStatistic>& all) const {
  for (std::size_t p = 0; p < projected_.size(); ++p) {
    const Projection& one = plan_.projections[p];
    const auto sums = by_lane(projected_[p], width_);
    if (sums.cols() == 1)
      all.push_back({one.name, Tail::both_sides, 1, 0.01, one.to_counts * sums.col(0)});
    else
      all.push_back(
          {one.name, Tail::chi_squared, 2, 0.01, one.to_counts * sums.square().rowwise().sum().sqrt()});
  }
}

/// Rms distance of the four states' means from the mean of all readings, weighted by their frequency.
Eigen::ArrayXd ResidualSums::by_count() const {
  const auto sums = by_lane(by_state_, width_), counts = by_lane(in_state_, width_);
  const Eigen::ArrayXXd off = sums / counts.max(1.0) - moments_.mean().replicate(1, 4);
  return (off.square() * counts / moments_.rows()).rowwise().sum().sqrt();
}

std::vector<ResidualStatistic> ResidualSums::statistics() const {
  std::vector<ResidualStatistic> all;
  const auto root = [](const Moments& m) -> Eigen::ArrayXd { return (12 * m.variance()).max(0.0).sqrt(); };
  if (plan_.e->encoder.zero_known) all.push_back({"mean", Tail::both_sides, 1, 0.01, moments_.mean()});
  all.push_back({"sigma_ratio", Tail::both_sides, 1, 0.01, root(moments_)});
  all.push_back({"uniformity", Tail::both_sides, 1, 0.01, distance_from_uniform()});
  if (plan_.e->ordered) add_correlations(all);
  add_projections(all);
  all.push_back({"by_count", Tail::chi_squared, 3, 0.01, by_count()});
  for (std::size_t f = 0; f < velocities_.size(); ++f)
    all.push_back(
        {plan_.velocities[f].name, Tail::both_sides, 1, 0.05, root(velocities_[f]) / plan_.velocities[f].h2});
  return all;
}

}  // namespace qerr
