#include <algorithm>
#include <optional>

#include "cli/shared.hpp"
#include "core/lists.hpp"
#include "core/text.hpp"
#include "input/csv.hpp"
#include "input/spec_variants.hpp"
#include "qerr/core/quantity.hpp"
#include "qerr/report/simulation_report.hpp"
#include "report/simulation/parts.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr::cli {

namespace {

constexpr std::size_t cutoffs_of_a_search = 25;  // 10 % to 25 % apart over one to two decades

Error wrong_cutoffs(const std::string& rule, const std::string& found) {
  return usage("--cutoffs", rule, quoted(found), "e.g. --cutoffs velocity=5Hz..200Hz");
}

/// `velocity=5Hz..200Hz`.
CutoffSearch search_of(const std::string& text) {
  const std::size_t equals = text.rfind('='),
                    dots = text.find("..", equals == std::string::npos ? 0 : equals);
  if (equals == std::string::npos || equals == 0 || dots == std::string::npos)
    throw wrong_cutoffs("must be FILTER=FROM..TO", text);
  const auto frequency = [&](const std::string& number) {
    std::string why;
    const auto quantity = parse_quantity(number, why);
    if (!quantity || (quantity->dimension && *quantity->dimension != dimension::frequency) ||
        !(quantity->value > 0))
      throw wrong_cutoffs(why.empty() ? "must be a frequency above 0" : why, number);
    return quantity->value;
  };
  const double from = frequency(text.substr(equals + 1, dots - equals - 1)),
               to = frequency(text.substr(dots + 2));
  if (!(from < to)) throw wrong_cutoffs("the first cut-off must be the lower one", text);
  return {text.substr(0, equals), cutoffs_between(from, to, cutoffs_of_a_search)};
}

/// The spec with the filter at every cut-off as its only filters.
Spec with_cutoffs(const CutoffSearch& search, const Values& v) {
  const SpecVariants variants(read_text(v.text("SPEC")), v.text("SPEC"), overrides(v));
  Spec spec = variants.base();
  if (!find_named(spec.filters, search.filter))
    throw usage("--cutoffs", "the spec has no such filter", quoted(search.filter),
                did_you_mean(search.filter, names_of(spec.filters)));
  if (std::ranges::none_of(spec.model.coordinates, is_position))
    throw usage("--cutoffs", "tracking errors are those of x, y and z", "none of them in the spec",
                "add one to 'coordinates'");
  spec.filters.clear();
  for (const double cutoff : search.values) {
    const std::string value = shortest(cutoff) + " Hz";
    const Spec one =
        variants.variant(spec_changes({{"filters." + search.filter + ".lowpass.cutoff", value}}));
    spec.filters.push_back(*find_named(one.filters, search.filter));
    spec.filters.back().name += ' ' + value;
  }
  return spec;
}

/// Estimators have no settling time of their own: a twentieth of the motion unless the spec says otherwise.
Spec settled(Spec spec) {
  if (spec.motion && !spec.motion->settling)
    spec.motion->settling =
        std::max(settling_time(*spec.motion, designed_filters(spec)), spec.motion->duration / 20);
  return spec;
}

/// What a run of a second's work at most shows, to tell whether an override changes it.
std::string brief_run(const Spec& spec, bool estimators) {
  constexpr double most = 1e5;  // samples
  if (!spec.motion || spec.motion->duration * spec.motion->sample_rate > most)
    throw Error({spec.file}, "motion", "too many samples to compare", "", "");
  SimulationOptions options;
  options.exact = true;
  SimulationReport report = simulation_report(spec, options);
  if (estimators) report.estimators = estimator_comparison(settled(spec), options);
  return write(report, "json");
}

int run_simulate(const Values& v) {
  const bool estimators = v.given("estimators");
  std::optional<CutoffSearch> search;
  if (v.given("cutoffs")) search = search_of(v.text("cutoffs"));
  Spec spec = search ? with_cutoffs(*search, v)
                     : load(v.text("SPEC"), v, {"requirements", "threshold", "sweep", "design"},
                            [=](const Spec& s) { return brief_run(s, estimators); });
  if (estimators) spec = settled(std::move(spec));
  limit_work(spec, spec.motion ? spec.motion->duration * spec.motion->sample_rate * v.number("runs") : 0,
             "motion.duration", "samples", v);
  OutputFile out(v.text("output"));
  const auto log = opened(v, "log");
  Outputs outputs;
  LogWriter rows(spec);
  SimulationOptions options;
  options.runs = v.whole("runs");
  options.random_phase = v.given("random-phase") || options.runs > 1;
  options.tracking = v.given("tracking") || search;
  options.exact = !search;
  options.seed = spec.configurations.seed;
  options.threads = threads(v);
  const std::string format = chosen_format(v);
  constexpr std::uint64_t samples_of_a_page = 1 << 16;
  if (format == "html" && !search) options.traced = samples_of_a_page;
  options.progress = progress(v, "samples");
  if (log) {
    log->write(rows.header());
    options.visit = [&](const Reading& reading) {
      outputs.write_next([&] { log->write(rows.row(reading)); });
    };
  }
  SimulationReport report = simulation_report(spec, options);
  report.cutoffs = search;
  if (estimators) {
    report.estimators = estimator_comparison(spec, options);
    for (std::string& text : estimator_warnings(spec)) report.warnings.push_back(std::move(text));
  }
  if (log) outputs.write_next([&] { log->close(); });
  outputs.write([&] { finish(out, report, format, style(v)); });
  warn(report.warnings, v);
  outputs.finish();
  return 0;
}

}  // namespace

Command simulate_command() {
  return {
      "simulate",
      "Simulate the quantizers along the motion: a log, and simulation compared with theory",
      joined({spec_options("the spec (YAML) with its motion; '-' reads standard input"),
              {valued("--log", "FILE.csv", "write the first run's log as CSV; '-' is standard output"),
               valued("--runs", "N",
                      "Monte-Carlo runs; several have random sub-count phases, a single one phase 0",
                      OptionKind::whole)
                   .within(1, 1e8)
                   .otherwise("1"),
               flag("--tracking", "also the errors that the filters make by lag and ripple, and the total"),
               flag("--estimators",
                    "rank the velocity filters and estimators of the spec by their errors along the motion"),
               valued("--cutoffs", "FILTER=FROM..TO",
                      "compare cut-offs of a filter: the least noise plus tracking error along the motion, "
                      "e.g. velocity=5Hz..200Hz"),
               flag("--random-phase",
                    "random sub-count phase of each encoder at its joint's zero, for a single run, too")},
              long_work_option(),
              output_options()}),
      run_simulate,
      {{"qerr simulate arm.yaml", "theory beside simulation along the spec's motion"},
       {"qerr simulate arm.yaml --runs 16", "with narrower confidence intervals"},
       {"qerr simulate arm.yaml --cutoffs velocity=5Hz..200Hz",
        "which cut-off has the least noise plus tracking error"},
       {"qerr simulate arm.yaml --estimators", "which velocity estimator has the least error"},
       {"qerr simulate arm.yaml --log log.csv", "and the log that a controller would have recorded"}},
      {"motion", "effects", "logs"}};
}

}  // namespace qerr::cli
