#include <memory>
#include <utility>

#include "bound/configuration_batch.hpp"
#include "cli/command.hpp"
#include "core/output_file.hpp"

namespace qerr::cli {

namespace {

struct Arguments {
  std::string spec;
  std::string per_configuration;
};

int run(const Arguments& arguments, const Options& o) {
  Spec spec = load(arguments.spec, o);
  OutputFile out(o.output);
  std::unique_ptr<OutputFile> rows;
  WorkspaceOptions options;
  options.threads = o.threads;
  options.progress = progress(o);
  options.noise_in_motion = noise_in_motion(spec);
  EffectReport effects = effect_report(spec);
  spec.model.sources = effects.sources;  // which the rows need too
  if (!arguments.per_configuration.empty()) {
    rows = std::make_unique<OutputFile>(arguments.per_configuration);
    rows->write(per_configuration_header(spec, options.noise_in_motion));
    options.text = [&](const ConfigurationBatch& batch) {
      return per_configuration_rows(spec, options.noise_in_motion, batch);
    };
    options.write = [&](const std::string& text) { rows->write(text); };
  }
  const Analysis analysis = analyze(spec, std::move(effects), options);
  if (rows) rows->close();
  out.write(write(analysis, chosen_format(o), style(o)));
  out.close();
  warn(analysis.warnings, o);
  return 0;
}

}  // namespace

std::function<int()> declare_analyze(CLI::App& app, Options& o) {
  auto arguments = std::make_shared<Arguments>();
  app.add_option("SPEC", arguments->spec, "the spec (YAML); '-' reads standard input")->required();
  app.add_option("--per-configuration", arguments->per_configuration, "write one CSV row per configuration")
      ->type_name("FILE.csv");
  add_spec_options(app, o);
  add_output_options(app, o);
  return [=, &o] { return run(*arguments, o); };
}

}  // namespace qerr::cli
