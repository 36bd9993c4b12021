#include "cli/command.hpp"
#include "cli/shared.hpp"
#include "qerr/report/analysis.hpp"

namespace qerr::cli {

namespace {

int run(const Values& v) {
  const Spec spec = load(v.text("SPEC"), v);
  limit_configurations(spec, v);
  OutputFile out(v.text("output"));
  const auto rows = opened(v, "per-configuration");
  const WorkspaceOptions options = workspace_options(v);
  Analysis analysis;
  if (rows) {
    analysis = analyze(spec, options, [&](const std::string& text) { rows->write(text); });
    rows->close();
  } else {
    analysis = analyze(spec, options);
  }
  Style shown = style(v);
  shown.details = v.given("details");
  finish(out, write(analysis, chosen_format(v), shown));
  warn(analysis.warnings, v);
  return 0;
}

}  // namespace

Command analyze_command() {
  return {
      "analyze",
      "Worst-case and IPQN bounds of position, velocity and acceleration over the configurations",
      joined({spec_options(),
              {{.name = "--per-configuration",
                .value = "FILE.csv",
                .meaning = "write one CSV row per configuration"},
               {.name = "--details",
                .kind = OptionKind::flag,
                .meaning = "in the table all statistics, in place of median and maximum"}},
              long_work_option(),
              output_options()}),
      run,
      {{"qerr analyze arm.yaml", "how far off the tip can be, and which encoder to upgrade first"},
       {"qerr analyze arm.yaml --set 'encoders.*.counts_per_rev=8192'",
        "the same with finer encoders, without changing the file"},
       {"qerr analyze arm.yaml -o report.json", "everything, for a program; the ending chooses the format"},
       {"qerr analyze arm.yaml --per-configuration points.csv", "and one row for every configuration"}},
      {"figures", "spec", "output"}};
}

}  // namespace qerr::cli
