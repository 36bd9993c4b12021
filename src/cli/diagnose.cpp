#include <filesystem>
#include <memory>

#include "cli/command.hpp"
#include "core/output_file.hpp"
#include "qerr/input/read_log.hpp"
#include "qerr/report/diagnosis_report.hpp"
#include "qerr/report/plan_report.hpp"

namespace qerr::cli {

namespace {

struct Arguments {
  std::string spec, log, model, table, plots;
  bool plan = false;
  std::string reference_noise;
};

/// A record is judged, or planned: with --plan there is none yet.
void refuse_half_questions(const Arguments& a) {
  if (!a.plan && a.log.empty())
    throw Error({{}, "LOG", "the record is missing", "", "give the log, or --plan when none exists yet"},
                Trouble::usage);
  if (!a.plan && !a.reference_noise.empty())
    throw Error(
        {{}, "--reference-noise", "a log tells its reference's noise itself", "", "it goes with --plan"},
        Trouble::usage);
  if (!a.plan) return;
  if (!a.log.empty())
    throw Error({{},
                 "--plan",
                 "plans are made before any log exists",
                 "'" + a.log + "'",
                 "leave out the log, or --plan"},
                Trouble::usage);
  for (const auto& [name, value] :
       {std::pair{"--write-model", &a.model}, {"--write-table", &a.table}, {"--plots", &a.plots}})
    if (!value->empty())
      throw Error({{}, name, "a plan has nothing to write there", "", "leave it out, or give a log"},
                  Trouble::usage);
}

/// At most one of the outputs may be standard output, and at most one of the inputs standard input.
void refuse_shared_streams(const Arguments& a, const Options& o) {
  if (a.spec == "-" && a.log == "-")
    throw Error(
        {{}, "SPEC LOG", "spec and log cannot both come from standard input", "", "name one as a file"},
        Trouble::usage);
  if ((o.output == "-") + (a.model == "-") + (a.table == "-") > 1)
    throw Error({{},
                 a.model == "-" ? "--write-model" : "--write-table",
                 "only one result can go to standard output",
                 "",
                 "add -o FILE for the report, or name a file"},
                Trouble::usage);
}

/// No result may take the place of what it was made from, or of another result.
void refuse_overwriting(const Arguments& a, const Options& o) {
  std::error_code none;
  const std::pair<const char*, const std::string*> results[] = {
      {"-o", &o.output}, {"--write-model", &a.model}, {"--write-table", &a.table}};
  for (const auto& [name, path] : results) {
    if (path->empty() || *path == "-") continue;
    for (const std::string* input : {&a.log, &a.spec})
      if (std::filesystem::equivalent(*path, *input, none))
        throw Error({{},
                     name,
                     "a result would overwrite what was measured or specified",
                     "'" + *path + "'",
                     "give it a name of its own"},
                    Trouble::usage);
    for (const auto& [other, same] : results)
      if (name != other && *path == *same)
        throw Error({{},
                     name,
                     "two results cannot have the same file",
                     "'" + *path + "'",
                     "give each a name of its own"},
                    Trouble::usage);
  }
}

/// A file that is asked for by its name, opened before the work.
std::unique_ptr<OutputFile> opened(const std::string& path) {
  return path.empty() ? nullptr : std::make_unique<OutputFile>(path);
}

void finish(OutputFile& file, const std::string& text) {
  file.write(text);
  file.close();
}

std::string prepared_folder(const std::string& path) {
  std::error_code wrong;
  std::filesystem::create_directories(path, wrong);
  if (!std::filesystem::is_directory(path))
    throw Error({{path, 0, 0}, "--plots", "cannot make the folder: " + wrong.message(), "", ""},
                Trouble::file_system);
  return path;
}

int run_plan(const Arguments& arguments, const Options& o) {
  const Spec spec = load(arguments.spec, o);
  OutputFile out(o.output);
  PlanOptions options;
  if (!arguments.reference_noise.empty()) options.reference_noise = *parse_number(arguments.reference_noise);
  const PlanReport report = plan_report(spec, options);
  finish(out, write(report, chosen_format(o), style(o)));
  warn(report.warnings, o);
  return 0;
}

int run(const Arguments& arguments, const Options& o) {
  refuse_half_questions(arguments);
  if (arguments.plan) return run_plan(arguments, o);
  refuse_shared_streams(arguments, o);
  refuse_overwriting(arguments, o);
  const Spec spec = load(arguments.spec, o);
  OutputFile out(o.output);
  const auto model = opened(arguments.model), table = opened(arguments.table);
  const std::string folder = arguments.plots.empty() ? "" : prepared_folder(arguments.plots);
  const auto residual = opened(folder.empty() ? "" : folder + "/residual.csv"),
             spectrum = opened(folder.empty() ? "" : folder + "/spectrum.csv");
  DiagnoseOptions options;
  options.seed = spec.configurations.seed;
  options.threads = o.threads;
  DiagnosisReport report = diagnosis_report(spec, read_log(arguments.log, spec), options);
  if (model) {
    finish(*model, extended_model(report, arguments.model));
    report.extended_model = arguments.model;
  }
  if (table) finish(*table, correction_table(report));
  if (residual) {
    const ResidualCurves curves = residual_curves(report);
    if (!curves.residual.empty()) finish(*residual, curves.residual);
    if (!curves.spectrum.empty()) finish(*spectrum, curves.spectrum);
    if (curves.residual.empty())
      report.warnings.push_back("--plots: no joint has a reference of its own: nothing to plot, no files");
    else if (curves.spectrum.empty())
      report.warnings.push_back("--plots: no joint moves: no spectrum.csv");
  }
  finish(out, write(report, chosen_format(o), style(o)));
  warn(report.warnings, o);
  return 0;
}

}  // namespace

std::function<int()> declare_diagnose(CLI::App& app, Options& o) {
  auto arguments = std::make_shared<Arguments>();
  app.add_option("SPEC", arguments->spec,
                 "the spec (YAML) of the robot as it should be; '-' reads standard input")
      ->required();
  app.add_option("LOG", arguments->log, "what was recorded (CSV); '-' reads standard input");
  app.add_flag("--plan", arguments->plan,
               "before any log exists: what a record of the spec's motion could show, and which motion would "
               "show more");
  app.add_option("--reference-noise", arguments->reference_noise,
                 "of the better sensors that --plan takes for granted, standard deviation in counts (0.05)")
      ->type_name("COUNTS")
      ->check([](const std::string& text) {
        const auto noise = parse_number(text);
        const bool sound = noise && *noise >= 1e-3 && *noise <= 10;
        return sound ? std::string() : "'" + text + "' is not a number of counts from 0.001 to 10";
      });
  app.add_option("--write-model", arguments->model,
                 "write the spec with the found effects in it; '-' is standard output")
      ->type_name("FILE.yaml");
  app.add_option("--write-table", arguments->table,
                 "write a look-up table for the controller: encoder angle to correction")
      ->type_name("FILE.csv");
  app.add_option("--plots", arguments->plots,
                 "write residual.csv and spectrum.csv there, for scripts/plot_diagnosis.py")
      ->type_name("FOLDER");
  add_spec_options(app, o);
  add_output_options(app, o);
  return [=, &o] { return run(*arguments, o); };
}

}  // namespace qerr::cli
