#include <filesystem>
#include <memory>

#include "cli/command.hpp"
#include "cli/shared.hpp"
#include "core/output_file.hpp"
#include "qerr/report/simulation_report.hpp"

namespace qerr::cli {

namespace {

bool same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return a != "-" && b != "-" && !a.empty() &&
         (std::filesystem::weakly_canonical(a, ignored) == std::filesystem::weakly_canonical(b, ignored));
}

int run(const Values& v) {
  const std::string& log_file = v.text("log");
  if (log_file == "-" && v.text("output") == "-")
    throw usage("--log", "log and report cannot both go to standard output", "",
                "add -o FILE for the report");
  for (const std::string& other : {v.text("SPEC"), v.text("output")})
    if (same_file(log_file, other))
      throw usage("--log", "the log would overwrite another file of this command", "'" + other + "'",
                  "give the log another name");
  const Spec spec = load(v.text("SPEC"), v);
  OutputFile out(v.text("output"));
  std::unique_ptr<OutputFile> log;
  LogWriter rows(spec);
  SimulationOptions options;
  options.runs = v.whole("runs");
  options.random_phase = v.given("random-phase") || options.runs > 1;
  options.seed = spec.configurations.seed;
  options.threads = threads(v);
  options.progress = progress(v);
  if (v.given("log")) {
    log = std::make_unique<OutputFile>(log_file);
    log->write(rows.header());
    options.visit = [&](const Reading& reading) { log->write(rows.row(reading)); };
  }
  const SimulationReport report = simulation_report(spec, options);
  if (log) log->close();
  finish(out, report, v);
  warn(report.warnings, v);
  return 0;
}

}  // namespace

Command simulate_command() {
  return {"simulate", "Simulate the quantizers along the motion: a log, and simulation compared with theory",
          joined({spec_options("the spec (YAML) with its motion; '-' reads standard input"),
                  {{.name = "--log",
                    .value = "FILE.csv",
                    .meaning = "write the first run's log as CSV; '-' is standard output"},
                   {.name = "--runs",
                    .value = "N",
                    .kind = OptionKind::whole,
                    .meaning = "Monte-Carlo runs; several have random sub-count phases, a single one phase 0",
                    .fallback = "1",
                    .least = 1,
                    .most = 1e8},
                   {.name = "--random-phase",
                    .kind = OptionKind::flag,
                    .meaning =
                        "random sub-count phase of each encoder at its joint's zero, for a single run, too"}},
                  output_options()}),
          run};
}

}  // namespace qerr::cli
