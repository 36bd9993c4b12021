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

}  // namespace

std::vector<std::vector<std::string>> visible_sizes(const Diagnosis& d) {
  std::vector<std::string> effects, joints;
  for (const Visible& v : d.visible)
    if (std::isfinite(v.smallest)) add_once(effects, v.effect), add_once(joints, v.joint);
  if (effects.empty()) return {};
  std::vector<std::vector<std::string>> rows{{"effect"}};
  for (const std::string& joint : joints) rows.front().push_back(shown(joint));
  for (const std::string& effect : effects) {
    rows.push_back({effect});
    for (const std::string& joint : joints) rows.back().push_back(cell(d, effect, joint));
  }
  return rows;
}

std::vector<std::string> hidden_lines(const Diagnosis& d) {
  std::vector<std::pair<std::string, std::string>> groups;  // joint, reason
  for (const Visible& v : d.visible) {
    const std::pair<std::string, std::string> group{v.joint, v.hidden_by};
    if (!std::isfinite(v.smallest) && std::find(groups.begin(), groups.end(), group) == groups.end())
      groups.push_back(group);
  }
  std::vector<std::string> out;
  for (const auto& [joint, reason] : groups) {
    std::vector<std::string> effects;
    for (const Visible& v : d.visible)
      if (!std::isfinite(v.smallest) && v.joint == joint && v.hidden_by == reason)
        add_once(effects, v.effect);
    out.push_back(shown(joint) + (reason.empty() ? "" : ", " + escaped(reason)) + ": " + listed(effects));
  }
  return out;
}

std::string visible_section(const DiagnosisReport& r, const Style& style) {
  const Diagnosis& d = r.diagnosis;
  if (d.verdict != Verdict::nothing_wrong && !style.details) return "";
  const std::vector<std::vector<std::string>> sizes = visible_sizes(d);
  const std::vector<std::string> hidden = hidden_lines(d);
  std::string out;
  if (!sizes.empty())
    out = heading("What this record would have shown, from these sizes on", style) +
          fitted_table(sizes, style.width);
  if (hidden.empty()) return out;
  out += heading("What this motion hides", style);
  for (const std::string& line : hidden) out += "  " + line + '\n';
  return out + "  `qerr diagnose SPEC --plan` proposes a motion that shows more.\n";
}

}  // namespace qerr
