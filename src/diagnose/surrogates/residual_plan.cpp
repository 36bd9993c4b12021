#include "diagnose/surrogates/residual_plan.hpp"

#include <cmath>

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

}  // namespace qerr
