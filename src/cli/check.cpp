#include <algorithm>
#include <cstdio>
#include <ctime>
#include <limits>
#include <map>

#include "cli/shared.hpp"
#include "core/text.hpp"
#include "input/csv.hpp"
#include "qerr/report/analysis.hpp"
#include "report/analysis/figures.hpp"
#include "report/text_table.hpp"

namespace qerr::cli {

namespace {

std::vector<std::string> annotation_forms() { return {"github"}; }

std::string now() {
  const std::time_t seconds = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  const std::size_t length = std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &utc);
  return {text, length};
}

/// Annotations stand below a table; any other text on standard output stands there alone.
void annotate(const std::string& text, bool below_table) {
  std::FILE* const to = below_table ? stdout : stderr;
  std::fputs(text.c_str(), to);
  std::fflush(to);
}

/// 0.02 of `2%` and of `0.02`.
double tolerance_of(const Values& v) {
  return part_of(v, "tolerance", 0, std::numeric_limits<double>::infinity(),
                 "must be a part of the baseline's figures, at least 0", "e.g. --tolerance 2%, or 0.02");
}

/// Read before the spec, so that a wrong file fails early.
Baselines baselines_of(const Values& v) {
  if (!v.given("baseline")) return {};
  const std::string& file = v.text("baseline");
  const double tolerance = tolerance_of(v);
  if (tolerance >= 1)
    warn({"--tolerance " + v.text("tolerance") + " is " + percent(tolerance) + ": a figure may grow to " +
          significant(1 + tolerance, 3) + " times that of the baseline; 2 % is 0.02 or 2%"},
         v);
  std::vector<std::string> inputs = v.texts("SPEC");
  inputs.push_back(file);
  refuse_shared_input(inputs, "--baseline");
  return read_baselines(read_text(file), file, tolerance);
}

/// One spec of several that is wrong does not hide the others.
CheckReport checked(const Baselines& baselines, const ProofRequest& proofs, const Values& v) {
  const WorkspaceOptions options = workspace_options(v);
  const std::vector<std::string>& paths = v.texts("SPEC");
  CheckReport report;
  std::map<std::string, const Baseline*> of_specs;  // one that is missing is a wrong command line for all
  if (v.given("baseline"))
    for (const std::string& path : paths) of_specs[path] = &baseline_of(baselines, path, paths.size() == 1);
  for (const std::string& path : paths) try {
      const Spec spec = load(path, v, {"threshold", "sweep", "design"}, [&](const Spec& s) {
        return v.given("baseline") ? figures_of_some(s, threads(v)) : verdicts_of_some(s, threads(v));
      });
      limit_configurations(spec, v);
      report.specs.push_back(check(spec, options, of_specs[path], proofs));
    } catch (const Error& e) {
      if (e.trouble() == Trouble::internal || e.trouble() == Trouble::usage) throw;
      report.broken.push_back({path, e});
    }
  return report;
}

/// @param annotated  whether annotations are asked for
CheckReport read_and_check(const Values& v, bool annotated) {
  try {
    ProofRequest proofs = proof_request(v);
    if (!v.given("prove")) proofs.of_distance = 0.1;  // the margin is shown to a tenth of itself
    const Baselines baselines = baselines_of(v);
    refuse_shared_input(v.texts("SPEC"), "SPEC");
    return checked(baselines, proofs, v);
  } catch (const Error& e) {
    if (annotated && e.trouble() != Trouble::usage) annotate(github_annotations(e), false);
    throw;
  }
}

/// The faults of all specs, where none could be checked, with the exit code of the first.
Error all_faults(const std::vector<BrokenSpec>& broken) {
  std::vector<Fault> faults;
  for (const BrokenSpec& b : broken)
    faults.insert(faults.end(), b.error.faults().begin(), b.error.faults().end());
  return Error(std::move(faults), broken.front().error.trouble());
}

int run_check(const Values& v) {
  const auto verdicts = opened(v, "junit");
  const auto out = opened_report(v, {"junit"});
  const bool annotated = v.given("annotations");
  const CheckReport report = read_and_check(v, annotated);
  const bool nothing_checked = report.specs.empty();
  if (nothing_checked && report.broken.front().error.trouble() == Trouble::file_system)
    throw all_faults(report.broken);
  Outputs outputs;
  if (verdicts && !(nothing_checked && v.text("junit") == "-"))
    outputs.write([&] { finish(*verdicts, junit(report, now())); });
  if (nothing_checked) {
    if (annotated) annotate(github_annotations(report), false);
    throw all_faults(report.broken);
  }
  if (out) outputs.write([&] { finish(*out, report, v); });
  const bool table = out && v.text("output") == "-" && chosen_format(v) == "table";
  if (annotated) annotate(github_annotations(report), table);
  SpecWarnings warnings;
  for (const SpecCheck& check : report.specs)
    warnings.emplace_back(check.analysis.spec.file, check.analysis.warnings);
  warn(warnings, v);
  outputs.finish();
  int code = report.all_met() ? 0 : 1;
  for (const BrokenSpec& b : report.broken) {
    print_error(b.error.what());
    code = std::max(code, static_cast<int>(b.error.trouble()));
  }
  return code;
}

}  // namespace

Command check_command() {
  std::vector<Option> options = joined(
      {spec_options("the specs (YAML); '-' reads standard input"),
       {valued("--junit", "FILE", "write the verdicts as JUnit XML"),
        valued("--annotations", "FORM", "github: `::error file=,line=` for each requirement that is not met")
            .one_of(annotation_forms, "form")},
       {valued("--baseline", "OLD.json",
               "an earlier report of check or analyze: no figure may be worse than there"),
        valued("--tolerance", "PART", "how much worse a figure may be, such as 2% or 0.02")
            .otherwise("0")
            .with("--baseline")},
       {prove_option("gap of requirements on proven_max, such as 0.1% (default: 1%, "
                     "or a tenth of the distance to the limit)")},
       long_work_option(),
       output_options_with_markdown()});
  options.front().kind = OptionKind::repeat;
  return {
      "check",
      "Compare the bounds with the requirements of specs; exit code 1 if one is not met",
      std::move(options),
      run_check,
      {{"qerr check arm.yaml", "are the spec's requirements met? Exit code 1 if one is not"},
       {"qerr check arm.yaml wrist.yaml --annotations github --junit qerr.xml",
        "in continuous integration, which shows verdicts at their lines"},
       {"qerr check arm.yaml wrist.yaml -o fleet.html", "a page of the verdicts, of one robot or of twelve"},
       {"qerr check arm.yaml --format md", "a table in Markdown, for a job's summary"},
       {"qerr analyze arm.yaml -o old.json", "today's figures, to be a baseline"},
       {"qerr check arm.yaml --baseline old.json --tolerance 2%",
        "has any figure become worse since, by more than 2 %?"}},
      {"requirements", "output"}};
}

}  // namespace qerr::cli
