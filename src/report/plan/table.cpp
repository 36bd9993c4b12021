#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/text.hpp"
#include "report/formats.hpp"
#include "report/plan/parts.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

/// The largest of the sizes over all orders and time constants of one family.
struct Cell {
  double detectable = 0, identifiable = 0;  // [counts]
};

std::optional<Cell> cell_of(const PlannedJoint& joint, const std::string& family) {
  std::optional<Cell> worst;
  for (const PlannedEffect& p : joint.effects) {
    if (family_of(p.effect) != family) continue;
    if (!worst) worst.emplace();
    worst->detectable = std::max(worst->detectable, p.detectable_counts());
    worst->identifiable = std::max(worst->identifiable, p.identifiable_counts());
  }
  return worst;
}

std::string text_of(const std::optional<Cell>& cell) {
  if (!cell) return "";
  if (!std::isfinite(cell->detectable)) return "none";
  return std::isfinite(cell->identifiable) ? significant(cell->identifiable, 2)
                                           : significant(cell->detectable, 2) + " ?";
}

std::vector<std::string> families(const std::vector<PlannedJoint>& joints) {
  std::vector<std::string> list;
  for (const PlannedJoint& joint : joints)
    for (const PlannedEffect& p : joint.effects)
      if (std::find(list.begin(), list.end(), family_of(p.effect)) == list.end())
        list.push_back(family_of(p.effect));
  return list;
}

/// Smallest sizes in counts: one row per effect, one column per joint that moves.
std::string matrix(const std::vector<PlannedJoint>& joints) {
  std::vector<std::vector<std::string>> rows{{""}};
  for (const PlannedJoint& joint : joints)
    if (joint.moves) rows[0].push_back(shown(joint.joint));
  for (const std::string& family : families(joints)) {
    std::vector<std::string>& row = rows.emplace_back(1, family);
    for (const PlannedJoint& joint : joints)
      if (joint.moves) row.push_back(text_of(cell_of(joint, family)));
  }
  return aligned(rows);
}

/// Pairs of families that are not distinguishable at a joint, each pair once.
std::set<std::pair<std::string, std::string>> pairs(const PlannedJoint& joint) {
  std::set<std::pair<std::string, std::string>> found;
  for (const PlannedEffect& p : joint.effects)
    for (const CorrelatedEffect& r : p.correlated)
      if (r.inseparable()) {
        const std::string a = family_of(p.effect), b = family_of(r.effect);
        if (!found.contains({b, a})) found.insert({a, b});
      }
  return found;
}

std::string record_for(const std::vector<PlannedJoint>& joints, const std::string& a, const std::string& b) {
  for (const PlannedJoint& joint : joints)
    for (const PlannedEffect& p : joint.effects)
      for (const CorrelatedEffect& r : p.correlated)
        if (r.inseparable() && ((family_of(p.effect) == a && family_of(r.effect) == b) ||
                                (family_of(p.effect) == b && family_of(r.effect) == a)))
          return r.record;
  return "";
}

/// Every pair with its joints, grouped by what to record to distinguish them.
std::string twins(const std::vector<PlannedJoint>& joints) {
  std::map<std::pair<std::string, std::string>, std::string> where;
  for (const PlannedJoint& joint : joints)
    for (const auto& pair : pairs(joint)) {
      std::string& names = where[pair];
      names += (names.empty() ? "" : ", ") + shown(joint.joint);
    }
  std::map<std::string, std::vector<std::string>> by_record;
  for (const auto& [pair, names] : where) {
    const auto& [a, b] = pair;
    by_record[record_for(joints, a, b)].push_back(
        (a == b ? a + " of two different orders" : a + " and " + b) + ": " + names);
  }
  std::string out;
  for (const auto& [record, lines] : by_record) {
    for (const std::string& line : lines) out += "  " + line + '\n';
    out += "    to distinguish them, record " + record + '\n';
  }
  return out;
}

std::size_t named_count(const PlannedJoint& joint) {
  std::size_t count = 0;
  for (const std::string& family : families({joint}))
    if (const auto cell = cell_of(joint, family); cell && std::isfinite(cell->identifiable)) ++count;
  return count;
}

/// One line per joint: the number of identifiable effects, in this and in the better motion.
std::string summary(const PlanReport& r) {
  const Plan& p = r.plan;
  std::vector<std::vector<std::string>> rows{
      {"joint", "readings", "effects", "identifiable", "better motion"}};
  for (std::size_t j = 0; j < p.joints.size(); ++j) {
    const PlannedJoint& joint = p.joints[j];
    const bool changed = std::find(p.changed.begin(), p.changed.end(), j) != p.changed.end();
    rows.push_back({shown(joint.joint), significant(std::round(joint.readings), 6),
                    joint.moves ? std::to_string(families({joint}).size()) : "",
                    joint.moves ? std::to_string(named_count(joint)) : "not moving: no verdict",
                    changed ? std::to_string(named_count(p.joints_better[j])) + " of " +
                                  std::to_string(families({p.joints_better[j]}).size())
                            : ""});
  }
  return aligned(rows);
}

std::string undetectable(const std::vector<PlannedJoint>& joints) {
  std::vector<std::string> lines;
  for (const PlannedJoint& joint : joints)
    for (const UndetectableEffect& u : joint.undetectable) {
      std::string required = escaped(u.required, 200);
      const std::string own = shown(joint.joint) + ".";
      if (const auto at = required.find(own); at != std::string::npos)
        required.replace(at, own.size(), "JOINT.");
      const std::string line = "  " + u.effect + " needs " + required + '\n';
      if (std::find(lines.begin(), lines.end(), line) == lines.end()) lines.push_back(line);
    }
  std::string out;
  for (const std::string& line : lines) out += line;
  return out + "  truncation is an offset of half a count in every motion; a datum distinguishes them\n";
}

std::string assumptions(const Plan& p) {
  return "Assumed: a reference of every encoder with a noise of " +
         significant(p.options.reference_noise, 3) +
         " counts;\neffects of the sizes below are identified with a probability of " +
         significant(100 * p.options.power, 3) + " %.\n";
}

}  // namespace

namespace {

std::string full_table(const PlanReport& r, const Style& style) {
  const Plan& p = r.plan;
  std::string out = painted("qerr diagnose --plan", Paint::bold, style) + "  robot '" +
                    shown(r.spec.robot_name) + "', " + significant(r.spec.motion->duration, 6) + " s at " +
                    readable(r.spec.motion->sample_rate, "Hz") + "\n\n" + assumptions(p) + '\n' + summary(r);
  const bool any = std::any_of(p.joints.begin(), p.joints.end(), [](const auto& j) { return j.moves; });
  if (any) {
    out += heading("Smallest identifiable size [counts, peak of what the effect adds]", style) +
           matrix(p.joints) +
           "  ?: detectable from this size on, identifiable at none; none: not detectable\n";
    if (const std::string list = twins(p.joints); !list.empty())
      out += heading("Not distinguishable in this motion", style) + list;
    out += heading("Not detectable in this log", style) + undetectable(p.joints);
  }
  if (!p.better) return out + "\nNone of the motions tried identifies clearly more.\n";
  out += heading(
             "With a better motion (same length and rate; only the joints' limits are known: check it for "
             "collisions)",
             style) +
         matrix(p.joints_better);
  if (const std::string list = twins(p.joints_better); !list.empty())
    out += heading("Still not distinguishable", style) + list;
  return out + heading("The better motion, for the spec", style) + motion_text(*p.better, r.spec.model.chain);
}

}  // namespace

std::string to_table(const PlanReport& r, const Style& style) {
  return within(full_table(r, style), style.width);
}

}  // namespace qerr
