#include <memory>

#include "cli/command.hpp"
#include "cli/shared.hpp"
#include "core/output_file.hpp"
#include "qerr/report/analysis.hpp"

namespace qerr::cli {

namespace {

int run(const Values& v) {
  const Spec spec = load(v.text("SPEC"), v);
  OutputFile out(v.text("output"));
  std::unique_ptr<OutputFile> verdicts;
  if (v.given("junit")) verdicts = std::make_unique<OutputFile>(v.text("junit"));
  WorkspaceOptions options;
  options.threads = threads(v);
  options.progress = progress(v);
  const CheckReport report = check_report(spec, options);
  if (verdicts) {
    verdicts->write(junit(report));
    verdicts->close();
  }
  finish(out, report, v);
  warn(report.analysis.warnings, v);
  return report.all_met() ? 0 : 1;
}

}  // namespace

Command check_command() {
  return {"check", "Compare the bounds with the spec's requirements; exit code 1 if one is not met",
          joined({spec_options(),
                  {{.name = "--junit", .value = "FILE", .meaning = "write the verdicts as JUnit XML"}},
                  output_options()}),
          run};
}

}  // namespace qerr::cli
