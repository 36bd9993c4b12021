#include "cli/command.hpp"
#include "cli/shared.hpp"
#include "qerr/report/analysis.hpp"

namespace qerr::cli {

namespace {

int run(const Values& v) {
  const Spec spec = load(v.text("SPEC"), v);
  limit_configurations(spec, v);
  const auto verdicts = opened(v, "junit");
  // Verdicts on standard output stand there alone: without -o or --format there is no other report.
  const bool only_verdicts = v.text("junit") == "-" && !v.given("output") && !v.given("format");
  const auto out = only_verdicts ? nullptr : opened(v, "output");
  WorkspaceOptions options;
  options.threads = threads(v);
  options.progress = progress(v, "configurations");
  const CheckReport report = check_report(spec, options);
  if (verdicts) finish(*verdicts, junit(report));
  if (out) finish(*out, report, v);
  warn(report.analysis.warnings, v);
  return report.all_met() ? 0 : 1;
}

}  // namespace

Command check_command() {
  return {"check",
          "Compare the bounds with the spec's requirements; exit code 1 if one is not met",
          joined({spec_options(),
                  {{.name = "--junit", .value = "FILE", .meaning = "write the verdicts as JUnit XML"}},
                  long_work_option(),
                  output_options()}),
          run,
          {{"qerr check arm.yaml", "are the spec's requirements met? Exit code 1 if one is not"},
           {"qerr check arm.yaml --junit qerr.xml",
            "in continuous integration, with verdicts that its pages show"}},
          {"requirements", "output"}};
}

}  // namespace qerr::cli
