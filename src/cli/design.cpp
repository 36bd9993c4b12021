#include "cli/shared.hpp"
#include "input/csv.hpp"
#include "input/spec_variants.hpp"
#include "qerr/report/design_report.hpp"
#include "report/text_table.hpp"

namespace qerr::cli {

namespace {

int run_design(const Values& v) {
  const std::string& path = v.text("SPEC");
  const SpecVariants variants(read_text(path), path, overrides(v));
  if (variants.base().design) refuse_chosen(variants.base(), overrides(v));
  limit_configurations(variants.base(), v);
  const auto out = opened_report(v, {"write-spec"});
  const auto written = opened(v, "write-spec");
  DesignOptions options;
  options.workspace.threads = threads(v);
  options.search_progress = search_progress(v);
  say_on_interrupt("--only-optimum, or a smaller configurations.count, takes less time");
  options.pareto = v.text("pareto");
  options.alternatives = !v.given("only-optimum");
  options.target = v.text("write-spec");
  DesignReport report = design(variants, options);
  append(report.warnings, idle_overrides(variants.base(), overrides(v), {"threshold", "sweep"}));
  Outputs outputs;
  if (written && report.optimal)
    outputs.write([&] { finish_spec(*written, report.written, options.target); });
  if (out) outputs.write([&] { finish(*out, report, v); });
  warn(report.warnings, v);
  outputs.finish();
  return report.optimal ? 0 : 1;
}

}  // namespace

Command design_command() {
  return {
      "design",
      "The cheapest or coarsest encoders, gears and filters that meet the requirements",
      joined(
          {spec_options(),
           {valued("--write-spec", "FILE", "write the spec with the choice in it, which `qerr check` passes"),
            valued("--pareto", "QUANTITY",
                   "figure of the front of prices, e.g. position.xyz.sigma or 'position.x.sigma p99' "
                   "(default: the tightest requirement's)"),
            flag("--only-optimum", "neither the prices of requirements nor the front")},
           long_work_option(),
           output_options()}),
      run_design,
      {{"qerr design arm.yaml", "which encoders to buy: what `design:` of the spec permits, at least price"},
       {"qerr design arm.yaml --write-spec chosen.yaml", "and write the spec that `qerr check` passes"},
       {"qerr design arm.yaml --set design.minimize=resolution", "the coarsest encoders that still pass"},
       {"qerr design arm.yaml --pareto position.xyz.sigma", "what each step of accuracy costs"}},
      {"choice", "requirements", "encoders"}};
}

}  // namespace qerr::cli
