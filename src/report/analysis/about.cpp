#include <algorithm>
#include <numbers>

#include "core/text.hpp"
#include "qerr/core/error.hpp"
#include "qerr/encoder/encoder.hpp"
#include "qerr/report/write.hpp"
#include "report/analysis/figures.hpp"
#include "report/analysis/tables.hpp"
#include "report/page/page.hpp"
#include "report/text_table.hpp"

namespace qerr::page {

namespace {

constexpr const char* line_break = "<br/>";

std::string overrides_of(const Spec& spec) {
  return joined(spec.overrides, line_break, [](const auto& o) {
    return "<code>" + escaped_markup(escaped(o.first + '=' + o.second, 300)) + "</code>";
  });
}

/// Encoders of many joints are alike: one line for all that have the same.
std::string encoders_of(const Spec& spec) {
  std::vector<std::pair<std::string, std::string>> kinds;  // description, joints
  for (std::size_t i = 0; i < spec.encoder_figures.size(); ++i) {
    const IndependentJoint& joint = spec.model.chain.independent[i];
    const Encoder& encoder = spec.model.transmission.encoders[i];
    const EncoderFigures& figures = spec.encoder_figures[i];
    const std::string unit = joint.unit();
    std::string text = readable(encoder.resolution, unit) + " at the joint";
    if (!joint.prismatic() || encoder_kind(figures.kind).counts_per_rev)  // not a linear scale
      text += ", " + significant(figures.counts_per_rev, 7) + " counts a revolution";
    if (figures.gear_ratio != 1) text += ", gear ratio " + significant(figures.gear_ratio, 6);
    if (encoder.accuracy > 0) text += ", accuracy " + readable(encoder.accuracy, unit);
    const std::string name = name_markup(joint.name);
    if (!kinds.empty() && kinds.back().first == text)
      kinds.back().second += ", " + name;
    else
      kinds.emplace_back(text, name);
  }
  return joined(kinds, line_break,
                [](const auto& kind) { return kind.second + ": " + escaped_markup(kind.first); });
}

/// A verdict as a word and a sign beside its colour.
std::string drawn_verdict(const RequirementResult& r) {
  return r.met         ? "<span class=\"verdict met\">\u2713 met</span>"
         : r.undecided ? "<span class=\"verdict open\">? not proven</span>"
                       : "<span class=\"verdict failed\">\u2717 not met</span>";
}

/// Where the tip errs most: joint by joint, `a1 -31.2 deg, ...`.
std::string place_of(const Chain& chain, const Eigen::VectorXd& q) {
  return configuration_text(chain, q, [](const IndependentJoint& joint, double value) {
    return isolated(joint.name) + ' ' +
           (joint.prismatic() ? readable(value, "m")
                              : fixed_point(value * 180 / std::numbers::pi, 1) + " deg");
  });
}

/// The results of the spec as its file has it; empty without overrides, and where it cannot be judged.
std::optional<std::vector<RequirementResult>> results_of_file(const Spec& spec) {
  if (spec.overrides.empty()) return std::nullopt;
  try {
    const Spec file = parse_spec(spec.text, spec.file);
    const bool same = std::equal(file.requirements.begin(), file.requirements.end(),
                                 spec.requirements.begin(), spec.requirements.end(),
                                 [](const auto& a, const auto& b) { return a.name() == b.name(); });
    return same ? verdicts_beside(file) : std::nullopt;
  } catch (const Error&) {  // only the override makes it a spec
    return std::nullopt;
  }
}

std::string requirement_list(const Spec& spec) {
  return joined(spec.requirements, line_break, [](const Requirement& r) { return name_markup(limited(r)); }) +
         line_break + "the spec itself is judged by qerr check";
}

}  // namespace

std::string requirement_table(const Spec& spec, const std::vector<RequirementResult>& results,
                              const std::string& caption) {
  const auto before = caption.empty() ? results_of_file(spec) : std::nullopt;
  std::vector<std::string> header{"verdict", "requirement", "value", "margin (bar: used)"}, rows;
  if (before) header.insert(header.end() - 1, "before --set");
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Requirement& r = spec.requirements[i];
    const RequirementResult& result = results[i];
    std::string row =
        "<td>" + drawn_verdict(result) + "</td>" + cell(limited(r)) + cell(value_text(r, result.value));
    if (before)
      row += cell(value_text(r, (*before)[i].value) + ((*before)[i].met == result.met ? ""
                                                       : (*before)[i].met             ? ", met"
                                                                                      : ", not met"));
    const auto part = part_of_limit(r, result);
    rows.push_back(row +
                   (part ? bar_cell(margin_text(r, result), *part, *part) : cell(margin_text(r, result))));
    if (!r.at_least && result.at_max.size() > 0)
      rows.push_back("<td class=\"where\" colspan=\"" + std::to_string(header.size()) + "\">largest at " +
                     escaped_markup(place_of(spec.model.chain, result.at_max)) + "</td>");
  }
  return "<div>" + (caption.empty() ? "" : "<b>" + caption + "</b>") + table_of("verdicts", header, rows) +
         "</div>";
}

std::string title_block(const Spec& spec, const std::optional<std::vector<RequirementResult>>& results,
                        const std::string& caption) {
  std::vector<std::pair<std::string, std::string>> rows{
      {"Spec", name_markup(spec.file) + ", SHA-256 " + spec.sha256.substr(0, 12)},
      {"Changed by --set", spec.overrides.empty() ? "nothing" : overrides_of(spec)},
      {"Encoders", encoders_of(spec)}};
  if (spec.requirements.empty())
    rows.emplace_back("Requirements", "none in the spec");
  else if (!results)
    rows.emplace_back("Requirements", requirement_list(spec));
  rows.emplace_back("Computed by", "qerr " + std::string(version()));
  return title_list(rows) + '\n' +
         (results && !results->empty() ? requirement_table(spec, *results, caption) : "") + "</div>\n";
}

void describe(Page& page, const Spec& spec, const std::optional<std::vector<RequirementResult>>& results,
              const std::string& caption) {
  page.spec_file = spec.file;
  page.spec_text = spec.text;
  page.about = title_block(spec, results, caption);
}

}  // namespace qerr::page
