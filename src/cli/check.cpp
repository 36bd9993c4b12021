#include <memory>
#include <utility>

#include "cli/command.hpp"
#include "core/output_file.hpp"
#include "qerr/report/effect_report.hpp"

namespace qerr::cli {

namespace {

struct Arguments {
  std::string spec;
  std::string junit;
};

int run(const Arguments& arguments, const Options& o) {
  const Spec spec = load(arguments.spec, o);
  OutputFile out(o.output);
  std::unique_ptr<OutputFile> report;
  if (!arguments.junit.empty()) report = std::make_unique<OutputFile>(arguments.junit);
  WorkspaceOptions options;
  options.threads = o.threads;
  options.progress = progress(o);
  EffectReport effects = effect_report(spec);
  require_known(spec, effects.shares);
  Analysis analysis = analyze(spec, std::move(effects), options);
  if (spec.requirements.empty())
    analysis.warnings.push_back("the spec has no requirements: nothing was checked");
  if (report) {
    report->write(junit(analysis));
    report->close();
  }
  out.write(write_check(analysis, chosen_format(o), style(o)));
  out.close();
  warn(analysis.warnings, o);
  return all_met(analysis) ? 0 : 1;
}

}  // namespace

std::function<int()> declare_check(CLI::App& app, Options& o) {
  auto arguments = std::make_shared<Arguments>();
  app.add_option("SPEC", arguments->spec, "the spec (YAML); '-' reads standard input")->required();
  app.add_option("--junit", arguments->junit, "write the verdicts as JUnit XML")->type_name("FILE");
  add_spec_options(app, o);
  add_output_options(app, o);
  return [=, &o] { return run(*arguments, o); };
}

}  // namespace qerr::cli
