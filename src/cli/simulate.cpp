#include <filesystem>
#include <memory>

#include "cli/command.hpp"
#include "core/output_file.hpp"
#include "qerr/report/simulation_report.hpp"

namespace qerr::cli {

namespace {

struct Arguments {
  std::string spec;
  std::string log;
  std::uint64_t runs = 1;
  bool random_phase = false;
};

bool same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  return a != "-" && b != "-" && !a.empty() &&
         (std::filesystem::weakly_canonical(a, ignored) == std::filesystem::weakly_canonical(b, ignored));
}

Error usage(const std::string& rule, const std::string& found, const std::string& remedy) {
  return Error({{}, "--log", rule, found, remedy}, Trouble::usage);
}

int run(const Arguments& arguments, const Options& o) {
  if (arguments.log == "-" && o.output == "-")
    throw usage("log and report cannot both go to standard output", "", "add -o FILE for the report");
  for (const std::string& other : {arguments.spec, o.output})
    if (same_file(arguments.log, other))
      throw usage("the log would overwrite another file of this command", "'" + other + "'",
                  "give the log a name of its own");
  const Spec spec = load(arguments.spec, o);
  OutputFile out(o.output);
  std::unique_ptr<OutputFile> log;
  LogWriter rows(spec);
  SimulationOptions options;
  options.runs = arguments.runs;
  options.random_phase = arguments.random_phase || arguments.runs > 1;
  options.seed = spec.configurations.seed;
  options.threads = o.threads;
  options.progress = progress(o);
  if (!arguments.log.empty()) {
    log = std::make_unique<OutputFile>(arguments.log);
    log->write(rows.header());
    options.visit = [&](const Reading& reading) { log->write(rows.row(reading)); };
  }
  const SimulationReport report = simulation_report(spec, options);
  if (log) log->close();
  out.write(write(report, chosen_format(o), style(o)));
  out.close();
  warn(report.warnings, o);
  return 0;
}

}  // namespace

std::function<int()> declare_simulate(CLI::App& app, Options& o) {
  auto arguments = std::make_shared<Arguments>();
  app.add_option("SPEC", arguments->spec, "the spec (YAML) with its motion; '-' reads standard input")
      ->required();
  app.add_option("--log", arguments->log, "write the first run's log as CSV; '-' is standard output")
      ->type_name("FILE.csv");
  app.add_option("--runs", arguments->runs,
                 "Monte-Carlo runs with random sub-count phases (default: 1, phase 0)")
      ->type_name("N")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{100'000'000}));
  app.add_flag(
      "--random-phase", arguments->random_phase,
      "where in a count each encoder stands at the joint's zero is drawn by the seed, for one run too");
  add_spec_options(app, o);
  add_output_options(app, o);
  return [=, &o] { return run(*arguments, o); };
}

}  // namespace qerr::cli
