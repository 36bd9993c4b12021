#include "cli/command.hpp"
#include "cli/shared.hpp"
#include "core/output_file.hpp"
#include "qerr/report/analysis.hpp"

namespace qerr::cli {

namespace {

int run(const Values& v) {
  ThresholdReport report;
  for (const std::string& path : v.texts("SPEC")) {
    const Spec spec = load(path, v);
    warn(spec.warnings, v);
    report.rows.push_back(threshold_row(spec, threads(v)));
  }
  OutputFile out(v.text("output"));
  finish(out, report, v);
  return 0;
}

}  // namespace

Command threshold_command() {
  std::vector<Option> options = joined({spec_options("one spec per robot"), output_options()});
  options.front().kind = OptionKind::repeat;
  return {"threshold", "Resolution and threshold velocity, one row per robot (Table IV)", std::move(options),
          run};
}

}  // namespace qerr::cli
