#include "diagnose/surrogates/residual_sums.hpp"

#include <algorithm>
#include <cmath>

#include "lanes/select_kernels.hpp"
#include "qerr/filter/norms.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index most_sampled_rows = 65536;

/// Share of a column's norm that must remain without its mean (convention): else a few rows would determine
/// the statistic.
constexpr double least_variation = 0.3;

Eigen::ArrayXd selected(const ResidualPlan& plan, const Eigen::ArrayXd& column) {
  Eigen::ArrayXd out(plan.rows);
  Eigen::Index row = 0;
  for (const RowRange& range : plan.ranges) {
    out.segment(row, range.rows) = column.segment(range.first, range.rows);
    row += range.rows;
  }
  return out;
}

/// Adds a projection on the columns without their means, unless they hardly vary.
void project(ResidualPlan& plan, const char* name, Eigen::ArrayXXd columns,
             double (*to_counts)(double n, double norm)) {
  double norm = 0;
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    const double size = std::sqrt(columns.col(i).square().sum());
    columns.col(i) -= columns.col(i).mean();
    for (Eigen::Index j = 0; j < i; ++j)
      columns.col(i) -= (columns.col(i) * columns.col(j)).sum() * columns.col(j);
    norm = std::sqrt(columns.col(i).square().sum());
    if (!(norm > least_variation * size)) return;
    columns.col(i) /= norm;
  }
  plan.projections.push_back({name, std::move(columns), to_counts(static_cast<double>(plan.rows), norm)});
}

void add_projections(ResidualPlan& plan, const ResidualKernels& kernels) {
  const Evidence& e = *plan.e;
  const auto rms = [](double n, double) { return 1 / std::sqrt(n); };
  const auto difference = [](double, double norm) { return 1 / norm; };
  if (e.ordered) {
    project(plan, "by_direction", selected(plan, e.direction), [](double, double norm) { return 2 / norm; });
    project(plan, "by_speed", selected(plan, e.velocity), rms);
    const double middle = 0.5 * (e.time[0] + e.time[e.rows() - 1]);
    project(plan, "by_time", selected(plan, (e.time > middle).cast<double>()), difference);
  }
  if (e.effort.size() > 0) project(plan, "by_effort", selected(plan, e.effort), rms);
  const Eigen::ArrayXd angle = selected(plan, e.encoder.shaft_ratio * e.path);
  // Over less than a third of a revolution a sine is not distinguishable from other slow curves.
  if (angle.maxCoeff() - angle.minCoeff() <= 2) return;
  Eigen::ArrayXXd wave(plan.rows, 2);
  kernels.sines(angle.data(), static_cast<std::size_t>(plan.rows), wave.col(0).data(), wave.col(1).data());
  project(plan, "by_angle", std::move(wave), [](double n, double) { return std::sqrt(2 / n); });
}

void add_velocities(ResidualPlan& plan, const std::vector<Filter>& filters) {
  const Evidence& e = *plan.e;
  if (!e.ordered || e.rows() < 64) return;
  const Eigen::ArrayXd intervals = e.time.tail(e.rows() - 1) - e.time.head(e.rows() - 1);
  int number = 0;
  for (const Filter& f : filters) {
    if (f.derivative != 1) continue;
    ++number;
    if ((intervals * f.sample_rate - 1).abs().maxCoeff() > 0.05) continue;
    const double modulus = poles_max_modulus(f);
    // The slowest mode decays to 0.1 %; the margin covers multiple poles.
    const double decay = modulus > 0 ? std::log(1e-3) / std::log(modulus) : 0;
    const auto settling = static_cast<Eigen::Index>(1.5 * decay) +
                          static_cast<Eigen::Index>(2 * f.sections.size() + f.taps.size());
    if (settling > plan.ranges.front().rows / 2) continue;
    plan.velocities.push_back({number == 1 ? "velocity_sigma" : "velocity_sigma_" + std::to_string(number),
                               &f, settling, norms(f).h2});
  }
}

}  // namespace

ResidualPlan residual_plan(const Evidence& e, const std::vector<Filter>& filters, InstructionSet set) {
  ResidualPlan plan{&e, sampled_ranges(e.rows(), most_sampled_rows), 0, {}, {}, {}, {}, {}};
  for (const RowRange& range : plan.ranges) plan.rows += range.rows;
  const Eigen::ArrayXd measured = selected(plan, e.measured);
  plan.residual = (measured - selected(plan, e.reference)) / e.step();
  if (!e.encoder.zero_known) plan.residual -= plan.residual.mean();
  plan.state = (measured / e.step()).unaryExpr([](double counts) {
    const double whole = std::round(counts);
    return whole - 4 * std::floor(0.25 * whole);
  });
  plan.surrogates = surrogate_plan(e, plan.ranges);
  add_projections(plan, select_kernels<ResidualKernels>(set));
  add_velocities(plan, filters);
  return plan;
}

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
