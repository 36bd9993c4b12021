#include "qerr/diagnose/plan.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/plan/better_motion.hpp"
#include "diagnose/plan/identifiability.hpp"
#include "diagnose/plan/planned_scatter.hpp"

namespace qerr {

namespace {

constexpr Eigen::Index rows_of_a_trial = 4000;
constexpr double of_a_twin = 30;        ///< times the size that is seen, when motions are compared
constexpr double worth_changing = 0.1;  ///< mean log of the sizes over all effects

void add_unseen(const Evidence& e, PlannedJoint& joint) {
  if (e.effort.size() == 0)
    joint.unseen.push_back(
        {"compliance", "the column " + e.joint + ".effort; the URDF has no masses to plan it with"});
  joint.unseen.push_back({"drift with the temperature", "the column " + e.joint + ".temperature"});
}

PlannedJoint planned_joint(const PlannedRecord& record, const PlanOptions& options) {
  const Evidence& e = record.evidence;
  PlannedJoint joint{e.joint, e.prismatic, false, 0, e.step(), {}, {}};
  joint.moves = e.path.maxCoeff() - e.path.minCoeff() >= e.step();
  joint.readings = record.weight.sum();
  if (!joint.moves) return joint;
  const Sight sight(record, options);
  joint.effects = sight.effects();
  for (PlannedEffect& p : planned_scatter(record, sight, options)) joint.effects.push_back(std::move(p));
  add_unseen(e, joint);
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

/// Sum of the logs of the sizes from which effects are named; twins count as large.
double difficulty(const PlannedJoint& joint) {
  double sum = 0;
  for (const PlannedEffect& p : joint.effects) {
    const double size = std::isfinite(p.named) ? std::min(p.named, of_a_twin * p.seen) : of_a_twin * p.seen;
    sum += std::isfinite(size) ? std::log(size) : 50;
  }
  return sum;
}

/// Whether a joint's record says clearly more than another.
bool says_more(const PlannedJoint& a, const PlannedJoint& than) {
  if (!a.moves || !than.moves) return a.moves;
  return difficulty(a) < difficulty(than) - worth_changing * static_cast<double>(a.effects.size());
}

/// Every joint does the best of its motions, or what it did where none is clearly better. The records of one
/// joint do not depend on what the others do but for its load and a coupling.
void improve(const OperationalModel& model, const std::vector<Effect>& present, const Motion& motion,
             Plan& plan) {
  const auto candidates = better_motions(model, motion);
  const bool tabled = motion.joints.empty();
  Motion best = motion;
  best.table = {};
  best.file.clear();
  if (tabled) best.joints.resize(candidates.size());
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
      if (i < candidates[j].size() && says_more(joints[j], record[j])) {
        record[j] = joints[j];
        best.joints[j] = trial.joints[j];
        changed[j] = true;
      }
  }
  // A motion from a file cannot be mixed with written ones.
  for (std::size_t j = 0; j < changed.size(); ++j)
    if (tabled && !changed[j] && plan.joints[j].moves) return;
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
