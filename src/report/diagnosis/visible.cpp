#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "report/diagnosis/parts.hpp"
#include "report/diagnosis/sections.hpp"
#include "report/fitted_table.hpp"
#include "report/text_table.hpp"

namespace qerr {

namespace {

std::string cell(const Diagnosis& d, const std::string& effect, const std::string& joint) {
  for (const Visible& v : d.visible)
    if (v.effect == effect && v.joint == joint && std::isfinite(v.smallest))
      return v.unit.empty()
                 ? significant(v.smallest, 2)
                 : significant(rounded_to(v.smallest, 2) / prefixed(v.smallest, v.unit).factor, 2) + ' ' +
                       prefixed(v.smallest, v.unit).unit;
  return "-";
}

/// Effects as rows, joints as columns; without rows and columns in which nothing is visible.
std::string sizes(const Diagnosis& d, const Style& style) {
  std::vector<std::string> effects, joints;
  for (const Visible& v : d.visible)
    if (std::isfinite(v.smallest)) add_once(effects, v.effect), add_once(joints, v.joint);
  if (effects.empty()) return "";
  std::vector<std::vector<std::string>> rows{{"effect"}};
  for (const std::string& joint : joints) rows.front().push_back(shown(joint));
  for (const std::string& effect : effects) {
    rows.push_back({effect});
    for (const std::string& joint : joints) rows.back().push_back(cell(d, effect, joint));
  }
  return heading("What this record would have shown, from these sizes on", style) +
         fitted_table(rows, style.width);
}

/// One line for all effects of a joint that are hidden for the same reason.
std::string hidden(const Diagnosis& d, const Style& style) {
  std::vector<std::pair<std::string, std::string>> groups;  // joint, reason
  for (const Visible& v : d.visible) {
    const std::pair<std::string, std::string> group{v.joint, v.hidden_by};
    if (!std::isfinite(v.smallest) && std::find(groups.begin(), groups.end(), group) == groups.end())
      groups.push_back(group);
  }
  std::string out;
  for (const auto& [joint, reason] : groups) {
    std::vector<std::string> effects;
    for (const Visible& v : d.visible)
      if (!std::isfinite(v.smallest) && v.joint == joint && v.hidden_by == reason)
        add_once(effects, v.effect);
    out +=
        "  " + shown(joint) + (reason.empty() ? "" : ", " + escaped(reason)) + ": " + listed(effects) + '\n';
  }
  if (out.empty()) return "";
  return heading("What this motion hides", style) + out +
         "  `qerr diagnose SPEC --plan` proposes a motion that shows more.\n";
}

}  // namespace

std::string visible_section(const DiagnosisReport& r, const Style& style) {
  const Diagnosis& d = r.diagnosis;
  if (d.verdict != Verdict::nothing_wrong && !style.details) return "";
  return sizes(d, style) + hidden(d, style);
}

}  // namespace qerr
