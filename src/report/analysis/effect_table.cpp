#include <cmath>

#include "core/text.hpp"
#include "kinematics/inverse_dynamics.hpp"
#include "qerr/effect/effect_kind.hpp"
#include "report/analysis/effects.hpp"
#include "report/text_table.hpp"

namespace qerr {

std::string parameters_text(const Spec& spec, const Effect& effect) {
  std::string text;
  for (const EffectParameter& p : effect_parameters(spec, effect)) {
    if (p.usual) continue;
    text += (text.empty() ? "" : ", ") + p.name + ' ' +
            (p.unit.empty() ? significant(p.value, 4) : readable(p.value, p.unit));
  }
  for (const Parameter& row : effect_kind(effect.type).parameters) {
    const auto choice = effect.choices.find(std::string(row.name));
    if (choice != effect.choices.end())
      text += (text.empty() ? "" : ", ") + choice->first + ' ' + choice->second;
  }
  return text;
}

namespace {

/// The lines, each with its text at the end; below it where the line would be too wide.
std::string with_texts(const std::string& lines, const std::vector<std::string>& texts, std::size_t width) {
  std::string out;
  std::size_t at = 0;
  for (const std::string& text : texts) {
    const std::size_t end = lines.find('\n', at);
    const std::string line = lines.substr(at, end - at);
    at = end + 1;
    if (text.empty() || display_width(line) + 2 + display_width(text) <= width)
      out += line + (text.empty() ? "" : "  " + text) + '\n';
    else
      out += line + '\n' + wrapped(text, width, "      ");
  }
  return out;
}

}  // namespace

std::string effect_table(const Spec& spec, const std::vector<EffectShare>& shares, const Style& style) {
  std::vector<std::vector<std::string>> rows{{"effect", "joint", "mean", "worst case", "sigma"}};
  std::vector<std::string> parameters{"parameters"};
  bool unknown = false, elsewhere = false;
  for (const EffectShare& s : shares) {
    const std::string unit = effect_unit(spec, s);
    std::vector<std::string> row{s.effect.type, shortened(s.effect.joint, 24)};
    if (!s.share) {
      row.insert(row.end(), {"?", "?", "?"});
      unknown = true;
    } else if (!s.included) {
      row.insert(row.end(), {"-", "-", "-"});
      elsewhere = true;
    } else {
      row.insert(row.end(), {readable(s.share->mean, unit),
                             readable(std::abs(s.share->mean) + s.share->half_width, unit),
                             readable(s.share->sigma, unit)});
    }
    parameters.push_back(parameters_text(spec, s.effect));
    rows.push_back(std::move(row));
  }
  return with_texts(aligned(rows), parameters, style.width) +
         (unknown ? "  ?: not known, and not in the figures below\n" : "") +
         (elsewhere ? "  -: affects the log or the reference only, not the robot\n" : "") +
         wrapped(
             !spec.motion ? "positions over the sampled ranges, speeds and loads up to the URDF's limits"
             : has_masses(spec.model.chain)
                 ? "what each adds alone along `motion:`"
                 : "what each adds alone along `motion:`, loads up to the URDF's limits: it has no masses",
             style.width, "  ");
}

}  // namespace qerr
