#include <cstdio>
#include <ctime>
#include <limits>
#include <optional>

#include "cli/command.hpp"
#include "cli/shared.hpp"
#include "core/text.hpp"
#include "input/read_text.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/report/analysis.hpp"

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
std::optional<Baseline> baseline_of(const Values& v) {
  if (!v.given("baseline")) return {};
  const std::string& file = v.text("baseline");
  const double tolerance = tolerance_of(v);
  if (v.texts("SPEC").size() > 1)
    throw usage("--baseline", "is a report of one spec", counted(v.texts("SPEC").size(), "spec"),
                "check each spec against a baseline of its own");
  refuse_shared_input({v.text("SPEC"), file}, "--baseline");
  return read_baseline(read_text(file), file, tolerance);
}

CheckReport checked(const std::vector<Spec>& specs, const Baseline* baseline, const ProofRequest& proofs,
                    const Values& v) {
  const WorkspaceOptions options = workspace_options(v);
  CheckReport report;
  for (const Spec& spec : specs) report.specs.push_back(check(spec, options, baseline, proofs));
  return report;
}

/// @param annotated  whether annotations are asked for
CheckReport read_and_check(const Values& v, bool annotated) {
  try {
    const ProofRequest proofs = proof_request(v);
    const std::optional<Baseline> baseline = baseline_of(v);
    refuse_shared_input(v.texts("SPEC"), "SPEC");
    std::vector<Spec> specs;
    for (const std::string& path : v.texts("SPEC")) {
      specs.push_back(load(path, v));
      limit_configurations(specs.back(), v);
    }
    return checked(specs, baseline ? &*baseline : nullptr, proofs, v);
  } catch (const Error& e) {
    if (annotated && e.trouble() != Trouble::usage) annotate(github_annotations(e), false);
    throw;
  }
}

int run(const Values& v) {
  const auto verdicts = opened(v, "junit");
  const auto out = opened_report(v, {"junit"});
  const bool annotated = v.given("annotations");
  const CheckReport report = read_and_check(v, annotated);
  Outputs outputs;
  if (verdicts) outputs.write([&] { finish(*verdicts, junit(report, now())); });
  if (out) outputs.write([&] { finish(*out, report, v); });
  const bool table = out && v.text("output") == "-" && chosen_format(v) == "table";
  if (annotated) annotate(github_annotations(report), table);
  for (const SpecCheck& check : report.specs) warn(check.analysis.warnings, v);
  outputs.finish();
  return report.all_met() ? 0 : 1;
}

}  // namespace

Command check_command() {
  std::vector<Option> options =
      joined({spec_options("the specs (YAML); '-' reads standard input"),
              {{.name = "--junit", .value = "FILE", .meaning = "write the verdicts as JUnit XML"},
               {.name = "--annotations",
                .value = "FORM",
                .meaning = "github: `::error file=,line=` for each requirement that is not met",
                .choices = annotation_forms,
                .choice = "form"}},
              {{.name = "--baseline",
                .value = "OLD.json",
                .meaning = "an earlier report of check or analyze: no figure may be worse than there"},
               {.name = "--tolerance",
                .value = "PART",
                .meaning = "how much worse a figure may be, such as 2% or 0.02",
                .fallback = "0",
                .needs = "--baseline"}},
              {prove_option("gap of requirements on proven_max, such as 0.1% (default: 1%)")},
              long_work_option(),
              output_options_without_page()});
  options.front().kind = OptionKind::repeat;
  return {"check",
          "Compare the bounds with the requirements of specs; exit code 1 if one is not met",
          std::move(options),
          run,
          {{"qerr check arm.yaml", "are the spec's requirements met? Exit code 1 if one is not"},
           {"qerr check arm.yaml wrist.yaml --annotations github --junit qerr.xml",
            "in continuous integration, which shows verdicts at their lines"},
           {"qerr analyze arm.yaml -o old.json", "today's figures, to be a baseline"},
           {"qerr check arm.yaml --baseline old.json --tolerance 2%",
            "has any figure become worse since, by more than 2 %?"}},
          {"requirements", "output"}};
}

}  // namespace qerr::cli
