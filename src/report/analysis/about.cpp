#include "report/analysis/about.hpp"

#include "core/text.hpp"
#include "qerr/encoder/encoder_kinds.hpp"
#include "qerr/report/write.hpp"
#include "report/analysis/requirements.hpp"
#include "report/page/markup.hpp"
#include "report/text_table.hpp"

namespace qerr::page {

namespace {

std::string term(const std::string& name, const std::string& description) {
  return "<dt>" + name + "</dt><dd>" + description + "</dd>";
}

std::string listed(const std::vector<std::string>& items) {
  std::string out;
  for (const std::string& item : items) out += (out.empty() ? "" : "<br/>") + item;
  return out;
}

std::string overrides_of(const Spec& spec) {
  std::vector<std::string> all;
  for (const auto& [key, value] : spec.overrides)
    all.push_back("<code>" + escaped_markup(escaped(key + '=' + value, 300)) + "</code>");
  return listed(all);
}

/// Encoders of many joints are alike: one line for all that have the same.
std::string encoders_of(const Spec& spec) {
  std::vector<std::pair<std::string, std::string>> kinds;  // description, joints
  for (std::size_t i = 0; i < spec.encoder_figures.size(); ++i) {
    const IndependentJoint& joint = spec.model.chain.independent[i];
    const Encoder& encoder = spec.model.transmission.encoders[i];
    const EncoderFigures& figures = spec.encoder_figures[i];
    const std::string unit = joint.prismatic() ? "m" : "rad";
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
  std::vector<std::string> lines;
  for (const auto& [text, joints] : kinds) lines.push_back(joints + ": " + escaped_markup(text));
  return listed(lines);
}

/// A verdict as a word and a sign beside its colour.
std::string drawn_verdict(const RequirementResult& r) {
  return r.met         ? "<span class=\"verdict met\">\u2713 met</span>"
         : r.undecided ? "<span class=\"verdict open\">? not proven</span>"
                       : "<span class=\"verdict failed\">\u2717 not met</span>";
}

std::string requirement_table(const Spec& spec, const std::vector<RequirementResult>& results) {
  std::string out = "<div class=\"wide\"><table class=\"verdicts\"><thead><tr>";
  for (const char* head : {"verdict", "requirement", "value", "margin"})
    out += std::string("<th scope=\"col\">") + head + "</th>";
  out += "</tr></thead><tbody>";
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Requirement& r = spec.requirements[i];
    out += "<tr><td>" + drawn_verdict(results[i]) + "</td><td>" + name_markup(limited(r)) + "</td><td>" +
           escaped_markup(readable(results[i].value, r.unit)) + "</td><td>" +
           escaped_markup(margin_text(r, results[i])) + "</td></tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string requirement_list(const Spec& spec) {
  std::vector<std::string> lines;
  for (const Requirement& r : spec.requirements) lines.push_back(name_markup(limited(r)));
  lines.emplace_back("the spec itself is judged by qerr check");
  return listed(lines);
}

}  // namespace

void describe(Page& page, const Spec& spec, const std::optional<std::vector<RequirementResult>>& results) {
  page.spec_file = spec.file;
  page.spec_text = spec.text;
  std::string rows = term("Spec", name_markup(spec.file) + ", SHA-256 " + spec.sha256.substr(0, 12)) +
                     term("Changed by --set", spec.overrides.empty() ? "nothing" : overrides_of(spec)) +
                     term("Encoders", encoders_of(spec));
  if (spec.requirements.empty())
    rows += term("Requirements", "none in the spec");
  else if (!results)
    rows += term("Requirements", requirement_list(spec));
  rows += term("Computed by", "qerr " + std::string(version()));
  page.about = "<div class=\"head\"><dl class=\"about\">" + rows + "</dl>\n" +
               (results && !results->empty() ? requirement_table(spec, *results) : "") + "</div>\n";
}

Bars use_of_limits(const std::vector<Requirement>& requirements,
                   const std::vector<RequirementResult>& results) {
  Bars bars{"Part of the limit that is used",
            "The value over the limit; for a lower limit the limit over the value. A requirement is "
            "met up to 100 %.",
            {{"the limit", 1, percent(1)}},
            {"", "%"},
            1};
  for (std::size_t i = 0; i < results.size(); ++i)
    if (const auto part = part_of_limit(requirements[i], results[i]))
      bars.bars.push_back({requirements[i].name(), *part, percent(*part), {}, *part > 1 ? 1 : 0});
  return bars;
}

}  // namespace qerr::page
