#include "cli/shared.hpp"
#include "core/text.hpp"
#include "input/csv.hpp"
#include "qerr/report/comparison.hpp"
#include "report/analysis/figures.hpp"
#include "report/text_table.hpp"

namespace qerr::cli {

namespace {

/// A report begins with a brace, as only a spec in flow style does, which is known by its name.
bool is_report(const std::string& text, const std::string& file) {
  if (file.ends_with(".yaml") || file.ends_with(".yml")) return false;
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  return begin != std::string::npos && text[begin] == '{';
}

void refuse_other_format(const std::string& text, const std::string& file) {
  const std::string first = text.substr(0, text.find_first_of("\r\n"));
  const bool table = file.ends_with(".txt") || first.starts_with("qerr ");
  // The header of a table has commas and no blanks.
  const bool header = first.find(',') != std::string::npos && first.find_first_of(" :#") == std::string::npos;
  const bool csv = file.ends_with(".csv") || header;
  if (csv || table)
    throw Error({file, 1, 1}, "", "only reports in JSON and specs can be compared", csv ? "CSV" : "a table",
                "write the report with --format json");
}

/// What stands on one side of the comparison: a report as it is, or a spec, which is computed.
struct Side {
  std::string file, text;
  bool report = false;

  explicit Side(const std::string& path) : file(path), text(read_text(path)), report(is_report(text, path)) {
    if (!report) refuse_other_format(text, file);
  }
};

SpecCheck computed(const Side& side, bool with_overrides, const Values& v) {
  SpecOverrides changes = overrides(v);
  if (!with_overrides) changes.values.clear();
  Spec spec = parse_spec(side.text, side.file, changes);
  append(spec.warnings, idle_overrides(spec, changes, {"threshold", "sweep", "design"},
                                       [&](const Spec& s) { return figures_of_some(s, threads(v)); }));
  limit_configurations(spec, v);
  const WorkspaceOptions options = workspace_options(v);
  return evaluate(spec, options);
}

ReportComparison compared(const Side& a, const Side& b, const Values& v) {
  if (a.report && b.report)
    return compare(read_named_figures(a.text, a.file), read_named_figures(b.text, b.file));
  if (a.report) {
    NamedFigures figures = read_named_figures(a.text, a.file);
    NamedFigures others = named_figures(computed(b, true, v), figures.command);
    return compare(std::move(figures), std::move(others));
  }
  if (b.report) {
    NamedFigures figures = read_named_figures(b.text, b.file);
    NamedFigures others = named_figures(computed(a, false, v), figures.command);
    return compare(std::move(others), std::move(figures));
  }
  return compare(named_figures(computed(a, false, v)), named_figures(computed(b, true, v)));
}

int run_compare(const Values& v) {
  refuse_shared_input({v.text("A"), v.text("B")}, "B");
  const Side a(v.text("A")), b(v.text("B"));
  if (b.report && v.given("set"))
    throw usage("--set", "changes the spec B, and B is a report", quoted(b.file), "name the report first");
  OutputFile out(v.text("output"));
  ReportComparison comparison = compared(a, b, v);
  comparison.details = v.given("details");
  finish(out, comparison, v);
  warn(comparison.warnings, v);
  return 0;
}

}  // namespace

Command compare_command() {
  std::vector<Option> options =
      joined({{valued("A", "", "a report of analyze, check or filter (JSON), or a spec (YAML)").must()},
              spec_options("the other report or spec"),
              {flag("--details", "show every figure, also unchanged ones")},
              long_work_option(),
              output_options()});
  options[1].name = "B";
  options[2].meaning = "override one value of B, which must be a spec, e.g. encoders.elbow.bits=19";
  return {
      "compare",
      "Two reports or specs side by side: which figures, shares and requirements changed",
      std::move(options),
      run_compare,
      {{"qerr compare arm.yaml wrist.yaml", "what differs between two designs"},
       {"qerr compare arm.yaml arm.yaml --set 'encoders.*.counts_per_rev=8192'", "what a change would do"},
       {"qerr analyze arm.yaml -o old.json", "today's figures"},
       {"qerr compare old.json arm.yaml --details", "what has changed since, figure by figure"}},
      {"requirements", "figures"}};
}

}  // namespace qerr::cli
