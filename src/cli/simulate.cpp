#include "cli/command.hpp"
#include "cli/shared.hpp"
#include "qerr/report/simulation_report.hpp"

namespace qerr::cli {

namespace {

int run(const Values& v) {
  const Spec spec = load(v.text("SPEC"), v);
  limit_work(spec, spec.motion ? spec.motion->duration * spec.motion->sample_rate * v.number("runs") : 0,
             "motion.duration", "samples", v);
  OutputFile out(v.text("output"));
  const auto log = opened(v, "log");
  LogWriter rows(spec);
  SimulationOptions options;
  options.runs = v.whole("runs");
  options.random_phase = v.given("random-phase") || options.runs > 1;
  options.seed = spec.configurations.seed;
  options.threads = threads(v);
  options.progress = progress(v, "samples");
  if (log) {
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
  return {"simulate",
          "Simulate the quantizers along the motion: a log, and simulation compared with theory",
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
                  long_work_option(),
                  output_options()}),
          run,
          {{"qerr simulate arm.yaml", "theory beside simulation along the spec's motion"},
           {"qerr simulate arm.yaml --runs 16", "with narrower confidence intervals"},
           {"qerr simulate arm.yaml --log log.csv", "and the log that a controller would have recorded"}},
          {"motion", "effects", "logs"}};
}

}  // namespace qerr::cli
