#include "cli/shared.hpp"
#include "input/read_sections.hpp"
#include "qerr/report/analysis.hpp"
#include "report/analysis/figures.hpp"

namespace qerr::cli {

namespace {

int run_analyze(const Values& v) {
  ProofRequest proofs = proof_request(v);
  proofs.all = v.given("prove");
  Spec spec = load(v.text("SPEC"), v, {"requirements", "threshold", "sweep", "design"},
                   [&](const Spec& s) { return figures_of_some(s, threads(v)); });
  const std::vector<Requirement> limits = read_limits("--above", v.texts("above"), spec);
  if (!limits.empty()) refuse_unreached(analysis_of_some(spec, threads(v)), limits, "--above");
  limit_configurations(spec, v);
  OutputFile out(v.text("output"));
  const auto rows = opened(v, "per-configuration");
  WorkspaceOptions options = workspace_options(v);
  // JSON and pages list them, whatever is printed.
  const std::string in = chosen_format(v);
  options.warnings = caller() || !v.given("quiet") || in == "html" || in == "json";
  ExceedanceCounter counter(spec, limits);
  if (!limits.empty()) options.visit = counter.visitor();
  Analysis analysis;
  Outputs outputs;
  if (rows) {
    analysis = analyze(
        spec, options, [&](const std::string& text) { outputs.write_next([&] { rows->write(text); }); },
        proofs);
    outputs.write_next([&] { rows->close(); });
  } else if (caller() && caller()->wants_columns) {
    analysis = analyze(spec, options, caller()->columns, proofs);
  } else {
    analysis = analyze(spec, options, proofs);
  }
  analysis.exceedances = counter.result(analysis);
  Style shown = style(v);
  shown.details = v.given("details");
  outputs.write([&] { finish(out, analysis, chosen_format(v), shown); });
  warn(analysis.warnings, v);
  outputs.finish();
  return 0;
}

}  // namespace

Command analyze_command() {
  return {
      "analyze",
      "Worst-case and IPQN bounds of position, velocity and acceleration over the configurations",
      joined({spec_options(),
              {valued("--per-configuration", "FILE.csv", "write one CSV row per configuration"),
               valued("--above", "QUANTITY=LIMIT",
                      "count the configurations above a limit, e.g. position.xyz.worst_case='50 um'",
                      OptionKind::repeat),
               prove_option("prove the maxima over the whole joint ranges, to a gap between what is reached "
                            "and what is never exceeded, such as 0.5% (default: 1%)"),
               flag("--details", "in the table all statistics, in place of median and maximum")},
              long_work_option(),
              output_options()}),
      run_analyze,
      {{"qerr analyze arm.yaml", "how far off the tip can be, and which encoder to upgrade first"},
       {"qerr analyze arm.yaml --set 'encoders.*.counts_per_rev=8192'",
        "the same with finer encoders, without changing the file"},
       {"qerr analyze arm.yaml --prove", "the largest errors that any configuration can have, proven"},
       {"qerr analyze arm.yaml -o report.json", "everything, for a program; the ending chooses the format"},
       {"qerr analyze arm.yaml --above position.xyz.worst_case='50 um'",
        "in what share of the workspace 50 um are exceeded, and where"},
       {"qerr analyze arm.yaml --per-configuration points.csv", "and one row for every configuration"}},
      {"figures", "spec", "output"}};
}

}  // namespace qerr::cli
