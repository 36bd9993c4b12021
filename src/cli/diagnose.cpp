#include <filesystem>
#include <memory>

#include "cli/shared.hpp"
#include "core/run_files.hpp"
#include "input/log_table.hpp"
#include "qerr/input/first_spec.hpp"
#include "qerr/input/read_log.hpp"
#include "qerr/report/diagnosis_report.hpp"
#include "report/formats.hpp"

namespace qerr::cli {

namespace {

LogFiles log_files(const Values& v) {
  if (caller() && !caller()->log.empty()) return caller()->log;
  return v.texts("LOG");
}

/// A log is diagnosed; --plan needs none.
void require_log_or_plan(const Values& v) {
  const bool in_memory = caller() && !caller()->log.empty();
  if (!v.given("plan") && !v.given("LOG") && !in_memory)
    throw usage("LOG", "the log is missing", "", "name the log, or use --plan if none exists yet");
  if (!v.given("plan") && v.given("reference-noise"))
    throw usage("--reference-noise", "the noise is estimated from the log", "", "use it with --plan only");
  if (!v.given("plan")) return;
  if (v.given("LOG"))
    throw usage("--plan", "a plan is made without a log", "'" + v.texts("LOG").front() + "'",
                "leave out the log, or --plan");
  for (const char* output :
       {"write-model", "write-table", "write-urdf", "plots", "check", "details", "hold", "column"})
    if (v.given(output))
      throw usage(std::string("--") + output, "not available for a plan", "", "leave it out, or name a log");
}

std::vector<Effect> effects_of(const Diagnosis& d) {
  std::vector<Effect> all;
  for (const Cause& c : d.causes) all.push_back(c.effect);
  return all;
}

std::string prepared_folder(const std::string& path) {
  std::error_code failure;
  std::filesystem::create_directories(path, failure);
  std::error_code unknown;
  if (!std::filesystem::is_directory(path, unknown))
    throw Error({path, 0, 0}, "--plots",
                "cannot create the folder: " + (failure ? failure : unknown).message(), "", "",
                Trouble::file_system);
  return path;
}

int run_plan(const Values& v) {
  const Spec spec = load(v.text("SPEC"), v, {"requirements", "threshold", "sweep", "design"});
  limit_work(spec, spec.motion ? spec.motion->duration * spec.motion->sample_rate : 0, "motion.duration",
             "samples", v);
  refuse_page(chosen_format(v));
  OutputFile out(v.text("output"));
  PlanOptions options;
  options.reference_noise = v.number("reference-noise");
  const PlanReport report = plan_report(spec, options);
  finish(out, report, v);
  warn(report.warnings, v);
  return 0;
}

void write_plots(DiagnosisReport& report, OutputFile& residual, OutputFile& spectrum) {
  const ResidualCurves curves = residual_curves(report);
  if (!curves.residual.empty()) finish(residual, curves.residual);
  if (!curves.spectrum.empty()) finish(spectrum, curves.spectrum);
  if (curves.residual.empty())
    report.warnings.emplace_back("--plots: no joint has a reference: no files are written");
  else if (curves.spectrum.empty())
    report.warnings.emplace_back("--plots: no joint moves: no spectrum.csv");
}

int run_diagnose(const Values& v) {
  require_log_or_plan(v);
  if (v.given("plan")) return run_plan(v);
  std::vector<std::string> inputs = v.texts("LOG");
  for (const std::string& log : inputs) note_input(log);  // the outputs are prepared before they are read
  inputs.push_back(v.text("SPEC"));
  refuse_shared_input(inputs, "LOG");
  Spec spec = load(v.text("SPEC"), v, {"requirements", "threshold", "sweep", "design"});
  if (v.given("hold")) spec.log.missing = MissingValues::hold;
  for (const std::string& assignment : v.texts("column")) map_column(assignment, spec);
  const auto out = opened_report(v, {"write-model", "write-urdf"});
  const auto model = opened(v, "write-model"), table = opened(v, "write-table"),
             urdf = opened(v, "write-urdf");
  if (urdf) urdf_as_built(spec, {});  // a robot without a URDF is refused before the work
  const std::string folder = v.given("plots") ? prepared_folder(v.text("plots")) : "";
  std::unique_ptr<OutputFile> residual, spectrum;
  if (!folder.empty()) {
    residual = std::make_unique<OutputFile>(folder + "/residual.csv", "--plots");
    spectrum = std::make_unique<OutputFile>(folder + "/spectrum.csv", "--plots");
  }
  DiagnoseOptions options;
  options.seed = spec.configurations.seed;
  options.threads = threads(v);
  Log log = read_log(log_files(v), spec, most_log_values, progress(v, "bytes"));
  const std::string format = chosen_format(v);
  // A page draws the record.
  const bool keep_values = table || residual || format == "html";
  DiagnosisReport report = diagnosis_report(spec, std::move(log), options, keep_values);
  Outputs outputs;
  if (model) {
    const std::string& path = v.text("write-model");
    outputs.write([&] { finish_spec(*model, extended_model(report, path), path); });
    report.extended_model = v.text("write-model");
  }
  if (urdf) outputs.write([&] { finish(*urdf, urdf_as_built(spec, effects_of(report.diagnosis))); });
  if (table) outputs.write([&] { finish(*table, correction_table(report)); });
  if (residual) outputs.write([&] { write_plots(report, *residual, *spectrum); });
  Style shown = style(v);
  shown.details = v.given("details");
  if (out) outputs.write([&] { finish(*out, report, format, shown); });
  warn(report.warnings, v);
  outputs.finish();
  return v.given("check") && !is_faultless(report.diagnosis) ? 1 : 0;
}

}  // namespace

Command diagnose_command() {
  return {
      "diagnose",
      "Find the causes of a measured log's errors: effects, an extended model, the gain",
      joined({spec_options("the spec (YAML) of the robot as designed; '-' reads standard input"),
              {valued("LOG", "",
                      "the measured log (CSV): one file, or several, which are joined by time; '-' reads "
                      "standard input",
                      OptionKind::repeat),
               flag("--hold",
                    "an empty cell of a log has the last value of its column, as with log: {missing: hold} "
                    "in the spec; --set log.missing=drop leaves its row out"),
               valued("--column", "SIGNAL=COLUMN",
                      "the log's column of a signal, such as a1.counts=q1_motor or 'a1.reference=q1_link "
                      "[deg]', as with log: {columns: ...} in the spec; without it a log of unknown columns "
                      "is answered with a mapping",
                      OptionKind::repeat),
               flag("--plan",
                    "without a log: which effects a log of the spec's motion would identify, and a motion "
                    "that identifies more"),
               valued("--reference-noise", "COUNTS",
                      "standard deviation of the reference sensors that --plan assumes, in counts",
                      OptionKind::number)
                   .within(1e-3, 10)
                   .otherwise("0.05"),
               flag("--check",
                    "end with 1 unless nothing is wrong, neither with the robot nor with the record "
                    "(corrupt, missing, repeated, contradictory readings), and all joints of the log are "
                    "judged, for continuous integration"),
               flag("--details", "in the table also the statistics, p-values, all intervals and gains"),
               valued("--write-model", "FILE.yaml",
                      "write the spec with the effects found; '-' is standard output"),
               valued("--write-table", "FILE.csv",
                      "write a look-up table for the controller: encoder angle to correction"),
               valued("--write-urdf", "FILE.urdf",
                      "write the URDF with the link dimensions found (geometry); all else is as in the file"),
               valued("--plots", "FOLDER",
                      "write residual.csv and spectrum.csv there, for scripts/plot_diagnosis.py")},
              long_work_option(),
              output_options()}),
      run_diagnose,
      {{"qerr diagnose arm.yaml log.csv", "what is wrong with the measured data, and why"},
       {"qerr diagnose arm.yaml log.csv --write-model found.yaml",
        "and the spec with the effects found, for analyze and check"},
       {"qerr diagnose arm.yaml encoders.csv tracker.csv",
        "the same for a log in two files, whose rows are joined by time"},
       {"qerr diagnose arm.yaml --plan",
        "before anything is recorded: what a record of the spec's motion would show"}},
      {"diagnosis", "logs", "effects"}};
}

}  // namespace qerr::cli
