#include "diagnose/surrogates/residual_plan.hpp"

#include <cmath>

#include "qerr/filter/norms.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index most_rows = 65536;
constexpr double least_left = 0.3;  ///< of a column without its mean: a few rows are no side and no speed

Eigen::ArrayXd chosen(const ResidualPlan& plan, const Eigen::ArrayXd& column) {
  Eigen::ArrayXd out(plan.rows);
  Eigen::Index at = 0;
  for (const Stretch& s : plan.parts) {
    out.segment(at, s.rows) = column.segment(s.first, s.rows);
    at += s.rows;
  }
  return out;
}

/// Adds a projection on what is left of the columns without their means; none where nothing is left.
void project(ResidualPlan& plan, const char* name, Eigen::ArrayXXd columns,
             double (*to_counts)(double n, double norm)) {
  double norm = 0;
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    const double size = std::sqrt(columns.col(i).square().sum());
    columns.col(i) -= columns.col(i).mean();
    for (Eigen::Index j = 0; j < i; ++j)
      columns.col(i) -= (columns.col(i) * columns.col(j)).sum() * columns.col(j);
    norm = std::sqrt(columns.col(i).square().sum());
    if (!(norm > least_left * size)) return;
    columns.col(i) /= norm;
  }
  plan.projections.push_back({name, std::move(columns), to_counts(static_cast<double>(plan.rows), norm)});
}

void add_projections(ResidualPlan& plan, const ResidualKernels& kernels) {
  const Evidence& e = *plan.e;
  const auto rms = [](double n, double) { return 1 / std::sqrt(n); };
  const auto difference = [](double, double norm) { return 1 / norm; };
  if (e.ordered) {
    project(plan, "by_direction", chosen(plan, e.direction), [](double, double norm) { return 2 / norm; });
    project(plan, "by_speed", chosen(plan, e.velocity), rms);
    const double middle = 0.5 * (e.time[0] + e.time[e.rows() - 1]);
    project(plan, "by_time", chosen(plan, (e.time > middle).cast<double>()), difference);
  }
  if (e.effort.size() > 0) project(plan, "by_effort", chosen(plan, e.effort), rms);
  const Eigen::ArrayXd angle = chosen(plan, e.encoder.shaft_ratio * e.path);
  // Over less than a third of a turn a sine is any slow curve.
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
    const double decay = modulus > 0 ? std::log(1e-3) / std::log(modulus) : 0;
    const auto settling = static_cast<Eigen::Index>(1.5 * decay) +
                          static_cast<Eigen::Index>(2 * f.sections.size() + f.taps.size());
    if (settling > plan.parts.front().rows / 2) continue;
    plan.velocities.push_back({number == 1 ? "velocity_sigma" : "velocity_sigma_" + std::to_string(number),
                               &f, settling, norms(f).h2});
  }
}

}  // namespace

ResidualPlan residual_plan(const Evidence& e, const std::vector<Filter>& filters, InstructionSet set) {
  ResidualPlan plan{&e, stretches(e.rows(), most_rows), 0, {}, {}, {}, {}, {}};
  for (const Stretch& s : plan.parts) plan.rows += s.rows;
  const Eigen::ArrayXd measured = chosen(plan, e.measured);
  plan.residual = (measured - chosen(plan, e.reference)) / e.step();
  if (!e.encoder.zero_known) plan.residual -= plan.residual.mean();
  plan.state = (measured / e.step()).unaryExpr([](double counts) {
    const double whole = std::round(counts);
    return whole - 4 * std::floor(0.25 * whole);
  });
  plan.surrogates = surrogate_plan(e, plan.parts);
  add_projections(plan, select_kernels<ResidualKernels>(set));
  add_velocities(plan, filters);
  return plan;
}

}  // namespace qerr
