#include "cli/shared.hpp"
#include "qerr/report/analysis.hpp"
#include "qerr/report/write.hpp"
#include "report/formats.hpp"

namespace qerr::cli {

namespace {

int run_threshold(const Values& v) {
  refuse_shared_input(v.texts("SPEC"), "SPEC");
  std::vector<Spec> specs;
  for (const std::string& path : v.texts("SPEC")) {
    specs.push_back(load(path, v, {"requirements", "motion", "sweep", "design"}, [&](const Spec& s) {
      return write(ThresholdReport{{threshold_row(s, threads(v))}}, "csv");
    }));
    limit_configurations(specs.back(), v);
  }
  OutputFile out(v.text("output"));
  ThresholdReport report;
  SpecWarnings warnings;
  for (const Spec& spec : specs) {
    report.rows.push_back(threshold_row(spec, threads(v)));
    warnings.emplace_back(spec.file, spec.warnings);
  }
  warn(warnings, v);
  const std::string above = chosen_format(v) == "table" ? changes_above(specs.front(), style(v).width) : "";
  finish(out, report, chosen_format(v), style(v), above);
  return 0;
}

}  // namespace

Command threshold_command() {
  std::vector<Option> options =
      joined({spec_options("one spec per robot"), long_work_option(), output_options_without_page()});
  options.front().kind = OptionKind::repeat;
  return {"threshold",
          "Resolution and threshold velocity, one row per robot (Table IV)",
          std::move(options),
          run_threshold,
          {{"qerr threshold arm.yaml wrist.yaml",
            "at which speed of the tip one sample holds one count, one row per robot"}},
          {"figures"}};
}

}  // namespace qerr::cli
