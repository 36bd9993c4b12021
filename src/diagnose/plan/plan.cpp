#include "qerr/diagnose/plan.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/plan/better_motion.hpp"
#include "diagnose/plan/identifiability.hpp"
#include "diagnose/plan/planned_scatter.hpp"
#include "qerr/effect/effect_kind.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index rows_of_a_trial = 4000;  ///< of a motion that is tried
// Conventions for the comparison of motions:
constexpr double inseparable_size = 30;   ///< size at which an inseparable effect counts, per detectable size
constexpr double undetectable_size = 50;  ///< logarithm of the size at which an undetectable effect counts
constexpr double least_improvement = 0.1;  ///< mean over all effects of the logarithm of their sizes

void add_undetectable(const Evidence& e, PlannedJoint& joint) {
  for (const EffectKind& kind : effect_kinds())
    if (kind.missing_signal)
      if (const auto missing = kind.missing_signal(e))
        joint.undetectable.push_back({missing->effect, missing->needs});
}

PlannedJoint planned_joint(const PlannedRecord& record, const PlanOptions& options) {
  const Evidence& e = record.evidence;
  PlannedJoint joint{e.joint, e.prismatic, false, 0, e.step(), {}, {}};
  joint.moves = e.path.maxCoeff() - e.path.minCoeff() >= e.step();
  joint.readings = record.weight.sum();
  if (!joint.moves) return joint;
  const Identifiability identifiability(record, options);
  joint.effects = identifiability.effects();
  for (PlannedEffect& p : planned_scatter(record, identifiability, options))
    joint.effects.push_back(std::move(p));
  add_undetectable(e, joint);
  return joint;
}

std::vector<PlannedJoint> planned_joints(const OperationalModel& model, const std::vector<Effect>& present,
                                         const Motion& motion, const PlanOptions& options,
                                         Eigen::Index rows) {
  std::vector<PlannedJoint> joints;
  for (const PlannedRecord& r : planned_records(model, present, motion, options.reference_noise, rows))
    joints.push_back(planned_joint(r, options));
  return joints;
}

/// Sum of the logarithms of the sizes from which effects are identifiable.
double difficulty(const PlannedJoint& joint) {
  double sum = 0;
  for (const PlannedEffect& p : joint.effects) {
    const double size = std::isfinite(p.identifiable)
                            ? std::min(p.identifiable, inseparable_size * p.detectable)
                            : inseparable_size * p.detectable;
    sum += std::isfinite(size) ? std::log(size) : undetectable_size;
  }
  return sum;
}

/// Whether one record of a joint is clearly more informative than another.
bool is_better(const PlannedJoint& a, const PlannedJoint& than) {
  if (!a.moves || !than.moves) return a.moves;
  return difficulty(a) < difficulty(than) - least_improvement * static_cast<double>(a.effects.size());
}

/// Chooses the best of its candidate motions for every joint, or the given motion if none is clearly better.
/// Joints are chosen independently: the record of one depends on the others only by its load and a coupling.
void improve(const OperationalModel& model, const std::vector<Effect>& present, const Motion& motion,
             Plan& plan) {
  const auto candidates = better_motions(model, motion);
  const bool from_file = motion.joints.empty();
  Motion best = motion;
  best.table = {};
  best.file.clear();
  if (from_file) best.joints.resize(candidates.size());
  std::vector<PlannedJoint> record = planned_joints(model, present, motion, plan.options, rows_of_a_trial);
  std::vector<bool> changed(candidates.size(), false);
  std::size_t most = 0;
  for (const auto& list : candidates) most = std::max(most, list.size());
  for (std::size_t i = 0; i < most; ++i) {
    Motion trial = best;
    for (std::size_t j = 0; j < candidates.size(); ++j)
      if (i < candidates[j].size()) trial.joints[j] = candidates[j][i];
    const auto joints = planned_joints(model, present, trial, plan.options, rows_of_a_trial);
    for (std::size_t j = 0; j < candidates.size(); ++j)
      if (i < candidates[j].size() && is_better(joints[j], record[j])) {
        record[j] = joints[j];
        best.joints[j] = trial.joints[j];
        changed[j] = true;
      }
  }
  // A table of positions cannot be combined with other motions.
  for (std::size_t j = 0; j < changed.size(); ++j)
    if (from_file && !changed[j] && plan.joints[j].moves) return;
  for (std::size_t j = 0; j < changed.size(); ++j)
    if (changed[j]) plan.changed.push_back(j);
  if (plan.changed.empty()) return;
  plan.joints_better = planned_joints(model, present, best, plan.options, plan.options.most_rows);
  plan.better = std::move(best);
}

}  // namespace

Plan plan(const OperationalModel& model, const std::vector<Effect>& present, const Motion& motion,
          const PlanOptions& options) {
  Plan p;
  p.options = options;
  p.joints = planned_joints(model, present, motion, options, options.most_rows);
  if (options.improve) improve(model, present, motion, p);
  return p;
}

}  // namespace qerr
