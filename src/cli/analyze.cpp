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
  WorkspaceOptions options;
  options.threads = threads(v);
  options.progress = progress(v);
  Analysis analysis;
  if (v.given("per-configuration")) {
    OutputFile rows(v.text("per-configuration"));
    analysis = analyze(spec, options, [&](const std::string& text) { rows.write(text); });
    rows.close();
  } else {
    analysis = analyze(spec, options);
  }
  finish(out, analysis, v);
  warn(analysis.warnings, v);
  return 0;
}

}  // namespace

Command analyze_command() {
  return {"analyze",
          "Worst-case and IPQN bounds of position, velocity and acceleration over the configurations",
          joined({spec_options(),
                  {{.name = "--per-configuration",
                    .value = "FILE.csv",
                    .meaning = "write one CSV row per configuration"}},
                  output_options()}),
          run};
}

}  // namespace qerr::cli
