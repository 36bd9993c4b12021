#include "diagnose/inference/finding.hpp"

#include <algorithm>

#include "core/parallel.hpp"
#include "core/random.hpp"
#include "diagnose/inference/model_choice.hpp"
#include "diagnose/record/integrated_autocorrelation.hpp"
#include "diagnose/terms/with_effects.hpp"
#include "qerr/kinematics/jacobian.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index enough_rows = 4096;
constexpr int most_passes = 2;

/// Rms of a joint's residual before its readings were repaired; empty where they were not.
std::optional<double> before_repair(const Sanity& sane, const std::string& joint) {
  for (const Cause& c : sane.causes)
    if (c.effect.joint == joint && c.gain.rms_before != c.gain.rms_after)
      for (std::size_t i = 0; i < sane.rms_before.size(); ++i)
        if (sane.model.chain.independent[i].name == joint && sane.rms_before[i] > 0)
          return sane.rms_before[i];
  return std::nullopt;
}

/// Scales the squares of all blocks to the residual as recorded, where the gain was computed from repaired
/// readings.
void undo_repair(HeldOut& held, double rms_before) {
  double squares = 0, rows = 0;
  for (const HeldOut::Block& b : held.blocks) squares += b.before, rows += b.rows;
  if (squares <= 0) return;
  const double factor = rms_before * rms_before * rows / squares;
  for (HeldOut::Block& b : held.blocks) b.before *= factor;
}

/// The model without unnamed terms, which a spec cannot state.
Explanation names_of(Explanation m) {
  const std::size_t all = m.terms().size();
  for (std::size_t i = all; i-- > 0;)
    if (!m.terms()[i].named()) m.remove(i);
  if (m.terms().size() < all) m.fit();
  return m;
}

/// Effects of the named terms, with their parameters.
std::vector<Effect> effects_of(const Explanation& m) {
  std::vector<Effect> effects;
  for (std::size_t i = 0; i < m.terms().size(); ++i) {
    const Term& t = m.terms()[i];
    if (!t.named()) continue;
    effects.push_back(t.effect);
    t.fill(effects.back(), m.coefficients(i));
  }
  return effects;
}

/// Whether an error of many counts leaves a residual. The residual of a large error is itself several counts,
/// of a shape that no term has to the last percent, and rows that repeat each other overstate it.
bool leaves_much(const Finding& f) {
  constexpr double many = 8;  // [counts]
  const Explanation& m = f.selection->model;
  const bool left = std::any_of(m.terms().begin(), m.terms().end(), [](const Term& t) { return !t.named(); });
  if (!left && integrated_autocorrelation(f.evidence, m) == 1) return false;
  const Eigen::ArrayXd error = (f.evidence.measured - f.evidence.reference) / f.evidence.step();
  return (error - error.mean()).square().mean() > many * many;
}

/// Repeats the selection with independent readings. Fewer rows suffice.
/// @return the selected groups of rows
std::vector<RowGroup> judge_remainder(const Evidence& record, std::uint64_t seed, Finding& f) {
  std::vector<RowGroup> groups = independent_rows(record, seed, enough_rows);
  f.evidence = group_means(record, groups);
  SelectOptions options;
  options.names_first = true;
  f.selection.emplace(select(f.evidence, options));
  // Overfitting reduces the autocorrelation of the residual: repeat with the larger estimate.
  double autocorrelation = integrated_autocorrelation(f.evidence, f.selection->model);
  for (int i = 0; i < most_passes && autocorrelation > f.evidence.rows_per_reading; ++i) {
    f.evidence.rows_per_reading = autocorrelation;
    f.selection.emplace(select(f.evidence, options));
    autocorrelation = integrated_autocorrelation(f.evidence, f.selection->model);
  }
  return groups;
}

/// Whether a joint's own weight can load it: its axis is not vertical.
bool is_loaded(const OperationalModel& model, const Log& log, Eigen::Index joint) {
  const std::size_t n = model.chain.independent.size();
  Eigen::VectorXd q(static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i) {
    const auto column = log.find(LogSignal::reference, i);
    if (!column) return true;
    q[static_cast<Eigen::Index>(i)] = log.values(0, *column);
  }
  const Eigen::Vector3d axis = jacobian(model.chain, q).bottomRows<3>().col(joint);
  return axis.head<2>().norm() > 0.1 * axis.norm();
}

std::unique_ptr<Finding> finding_of(const Evidence& record, const Sanity& sane, std::uint64_t seed) {
  auto f = std::make_unique<Finding>();
  std::vector<RowGroup> groups = independent_rows(record, seed);
  f->evidence = group_means(record, groups);
  f->selection.emplace(select(f->evidence));
  if (leaves_much(*f)) groups = judge_remainder(record, seed, *f);
  f->scatter = scatter_of(f->evidence, f->selection->model);
  f->held = hold_out(record, f->evidence, groups, names_of(f->selection->model));
  if (const auto before = before_repair(sane, record.joint)) undo_repair(f->held, *before);
  return f;
}

}  // namespace

std::vector<std::unique_ptr<Finding>> findings_of(std::vector<Evidence> all, const Sanity& sane,
                                                  const DiagnoseOptions& options) {
  for (Evidence& e : all) e.loaded = is_loaded(sane.model, sane.log, e.number);
  std::vector<std::unique_ptr<Finding>> findings(all.size());
  const auto find = [&](bool coupled) {
    parallel_for(all.size(), options.threads, [&](std::size_t i) {
      if (all[i].coupled() == coupled)
        findings[i] = finding_of(all[i], sane, stream_seed(options.seed, "rows", i));
    });
  };
  find(false);
  std::vector<Effect> found;
  for (const auto& f : findings)
    if (f)
      for (Effect& effect : effects_of(f->selection->model)) found.push_back(std::move(effect));
  add_coupled_effects(all, sane.model.transmission, found);
  find(true);
  return findings;
}

}  // namespace qerr
