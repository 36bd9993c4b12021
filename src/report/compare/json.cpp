#include "qerr/report/comparison.hpp"
#include "report/formats.hpp"
#include "report/json_value.hpp"

namespace qerr {

namespace {

Json source_json(const NamedFigures& f) { return {{"file", f.file}, {"command", f.command}}; }

Json judged_json(const std::optional<JudgedRequirement>& r) {
  if (!r) return {};
  Json json = {{r->at_least ? "at_least" : "at_most", r->limit}};
  json["value"] = r->figure.value;
  json["met"] = r->met;
  json["margin"] = margin(*r);
  return json;
}

/// Null stands for what is unbounded; `only` names the report that has a figure alone.
Json figure_json(const FigureChange& f) {
  Json json = {{"figure", f.figure.quantity},
               {"statistic", f.figure.statistic},
               {"unit", f.figure.unit},
               {"a", f.a},
               {"b", f.b},
               {"change", f.relative}};
  if (!f.in_both()) json["only"] = f.a ? "a" : "b";
  return json;
}

}  // namespace

std::string to_json(const ReportComparison& c, const Style&) {
  Json figures = Json::array(), shares = Json::array(), requirements = Json::array();
  for (const FigureChange& f : c.figures) figures.push_back(figure_json(f));
  for (const ShareChange& s : c.shares) {
    const std::optional<double> change = s.a && s.b ? std::optional(*s.b - *s.a) : std::nullopt;
    shares.push_back({{"encoder", s.encoder}, {"a", s.a}, {"b", s.b}, {"change", change}});
  }
  for (const RequirementChange& r : c.requirements)
    requirements.push_back({{"quantity", r.any().figure.quantity},
                            {"statistic", r.any().figure.statistic},
                            {"unit", r.any().figure.unit},
                            {"a", judged_json(r.a)},
                            {"b", judged_json(r.b)},
                            {"flipped", r.flipped()},
                            {"flips_after", r.flips_after()}});
  Json j = {{"qerr", version()}, {"command", "compare"}, {"a", source_json(c.a)}, {"b", source_json(c.b)}};
  j["figures"] = figures;
  j["shares"] = shares;
  j["requirements"] = requirements;
  j["warnings"] = c.warnings;
  return j.document();
}

}  // namespace qerr
