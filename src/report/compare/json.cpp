#include "qerr/report/comparison.hpp"
#include "report/csv_text.hpp"
#include "report/formats.hpp"
#include "report/json_header.hpp"

namespace qerr {

/// Of a requirement A and B are whether it is met, and the change is `flipped` or empty.
std::string to_csv(const ReportComparison& c, const Style&) {
  std::string out = "section,name,statistic,unit,a,b,change\r\n";
  for (const RequirementChange& r : c.requirements)
    out += "requirement," + csv_cells(json_of(r), {"quantity", "statistic", "unit", "a.met", "b.met"}) +
           (r.flipped() ? ",flipped" : ",") + "\r\n";
  for (const FigureChange& f : c.figures)
    out += "figure," + csv_cells(json_of(f), {"figure", "statistic", "unit", "a", "b", "change"}) + "\r\n";
  for (const ShareChange& s : c.shares) {
    const Json share = json_of(s);
    out +=
        "share," + csv_cells(share, {"encoder"}) + ",,1," + csv_cells(share, {"a", "b", "change"}) + "\r\n";
  }
  return out;
}

RowsOf<NamedFigures> rows(Of<NamedFigures>) {
  return {{"file", &NamedFigures::file},
          {"command", &NamedFigures::command, one_of({"analyze", "check", "filter", "spec"}),
           "that wrote the report; spec: its figures are those of now"}};
}

RowsOf<JudgedRequirement> rows(Of<JudgedRequirement>) {
  return {{"at_most", [](auto& r) { return only_if(!r.at_least, r.limit); }, optional},
          {"at_least", [](auto& r) { return only_if(r.at_least, r.limit); }, optional},
          {"value", [](auto& r) { return r.figure.value; }, "null: unbounded", nullable},
          {"met", &JudgedRequirement::met},
          {"margin", [](auto& r) { return margin(r); }, "distance from the limit over the limit", nullable}};
}

RowsOf<FigureChange> rows(Of<FigureChange>) {
  return {{"figure", [](auto& f) { return f.figure.quantity; }, "the name that requirements use"},
          {"statistic", [](auto& f) { return f.figure.statistic; }, "empty: a figure of a filter"},
          {"unit", [](auto& f) { return f.figure.unit; }},
          {"a", &FigureChange::a, "null: unbounded, or only B has it"},
          {"b", &FigureChange::b, "null: unbounded, or only A has it"},
          {"change", &FigureChange::relative,
           "(b - a)/|a|; null: from zero, to unbounded, or one report only", nullable},
          {"only", [](auto& f) { return f.in_both() ? ""
                                        : f.a       ? "a"
                                                    : "b"; }, one_of({"a", "b"}),
           "the report that has the figure, if one has it", optional}};
}

RowsOf<ShareChange> rows(Of<ShareChange>) {
  return {
      {"encoder", &ShareChange::encoder},
      {"a", &ShareChange::a},
      {"b", &ShareChange::b},
      {"change", [](auto& s) { return s.a && s.b ? std::optional(*s.b - *s.a) : std::nullopt; }, "b - a"}};
}

RowsOf<RequirementChange> rows(Of<RequirementChange>) {
  return {{"quantity", [](auto& r) { return r.any().figure.quantity; }},
          {"statistic", [](auto& r) { return r.any().figure.statistic; }, "empty: a figure of a filter"},
          {"unit", [](auto& r) { return r.any().figure.unit; }},
          {"a", &RequirementChange::a, "null: only B has it"},
          {"b", &RequirementChange::b, "null: only A has it"},
          {"flipped", &RequirementChange::flipped},
          {"flips_after", &RequirementChange::flips_after, "part of the way from A to B"}};
}

RowsOf<ReportComparison> rows(Of<ReportComparison>) {
  return header<ReportComparison>("compare").with(
      {{"a", &ReportComparison::a},
       {"b", &ReportComparison::b},
       {"figures", &ReportComparison::figures, "the largest changes first"},
       {"shares", &ReportComparison::shares, "of each encoder in the variance of the tip"},
       {"requirements", &ReportComparison::requirements,
        "flipped ones first, in their order; then the smallest margins in B"},
       {"warnings", &ReportComparison::warnings}});
}

}  // namespace qerr
