#include <memory>

#include "command.hpp"
#include "qerr/core/output_file.hpp"
#include "qerr/input/read_log.hpp"
#include "qerr/report/diagnosis_report.hpp"

namespace qerr::cli {

namespace {

struct Arguments {
  std::string spec, log, model;
};

int run(const Arguments& arguments, const Options& o) {
  if (arguments.spec == "-" && arguments.log == "-")
    throw Error(
        {{}, "SPEC LOG", "spec and log cannot both come from standard input", "", "name one as a file"},
        Trouble::usage);
  if (arguments.model == "-" && o.output == "-")
    throw Error({{},
                 "--write-model",
                 "model and report cannot both go to standard output",
                 "",
                 "add -o FILE for the report"},
                Trouble::usage);
  const Spec spec = load(arguments.spec, o);
  OutputFile out(o.output);
  const auto model = arguments.model.empty() ? nullptr : std::make_unique<OutputFile>(arguments.model);
  DiagnoseOptions options;
  options.seed = spec.configurations.seed;
  options.threads = o.threads;
  options.progress = progress(o);
  DiagnosisReport report = diagnosis_report(spec, read_log(arguments.log, spec), options);
  if (model) {
    model->write(extended_model(report, arguments.model));
    model->close();
    report.extended_model = arguments.model;
  }
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
  app.add_option("--write-model", arguments->model,
                 "write the spec with the found effects in it; '-' is standard output")
      ->type_name("FILE.yaml");
  add_spec_options(app, o);
  add_output_options(app, o);
  return [=, &o] { return run(*arguments, o); };
}

}  // namespace qerr::cli
