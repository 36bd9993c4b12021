#include <memory>

#include "command.hpp"
#include "qerr/core/output_file.hpp"
#include "qerr/input/read_log.hpp"
#include "qerr/report/diagnosis_report.hpp"

namespace qerr::cli {

namespace {

struct Arguments {
  std::string spec, log;
};

int run(const Arguments& arguments, const Options& o) {
  if (arguments.spec == "-" && arguments.log == "-")
    throw Error(
        {{}, "SPEC LOG", "spec and log cannot both come from standard input", "", "name one as a file"},
        Trouble::usage);
  const Spec spec = load(arguments.spec, o);
  OutputFile out(o.output);
  DiagnoseOptions options;
  options.seed = spec.configurations.seed;
  options.threads = o.threads;
  options.progress = progress(o);
  const DiagnosisReport report = diagnosis_report(spec, read_log(arguments.log, spec), options);
  out.write(write(report, chosen_format(o), style(o)));
  out.close();
  warn(report.warnings, o);
  return 0;
}

}  // namespace

std::function<int()> declare_diagnose(CLI::App& app, Options& o) {
  auto arguments = std::make_shared<Arguments>();
  app.add_option("SPEC", arguments->spec,
                 "the spec (YAML) of the robot as it should be; '-' reads standard input")
      ->required();
  app.add_option("LOG", arguments->log, "what was recorded (CSV); '-' reads standard input")->required();
  add_spec_options(app, o);
  add_output_options(app, o);
  return [=, &o] { return run(*arguments, o); };
}

}  // namespace qerr::cli
