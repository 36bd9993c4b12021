#include "report/output_schemas.hpp"

namespace qerr {

namespace {

Json filter_choice_schema() {
  using namespace schema;
  const Json best = object({{"taps", number(), "of the filters compared with"},
                            {"h2_norm", number(), "of the quietest one found"},
                            {"h2_norm_bound", number(), "none with as many taps falls below"},
                            {"ratio", number(), "of the chosen filter's norm to it"}});
  return object(
      {{"family", text()},
       {"order", number()},
       {"cutoff", number(), "Hz"},
       {"h2_norm", number()},
       {"l1_norm", number()},
       {"delay", number(), "at 0 Hz, s"},
       {"tracking_error", number_or_null(), "largest up to the band's end; null: no band is stated"},
       {"best_linear", or_null(best), "the quietest filter of that tracking error; null: no band"}});
}

Json design_choice_schema() {
  using namespace schema;
  const Json requirement = object({{"quantity", text()},
                                   {"statistic", text(), "not of a figure of a filter", true},
                                   {"at_most", number(), "", true},
                                   {"at_least", number(), "", true},
                                   {"value", number_or_null(), "null: unbounded"},
                                   {"unit", text()},
                                   {"met", boolean()}});
  return or_null(object(
      {{"price", number_or_null(), "of all encoders; null: not stated of one"},
       {"bits", number(),
        "sum over the joints of the binary logarithm of the intervals in a turn, or in 1 m"},
       {"value", number_or_null(), "of the quantity that is minimized", true},
       {"encoders", map(text()), "name of the option by joint"},
       {"filters", map(filter_choice_schema()), "by name"},
       {"requirements", list(requirement)},
       {"set", list(text()),
        "KEY=VALUE for --set: encoders and filters of the choice; effects of catalogue rows are only in "
        "what --write-spec writes"}}));
}

}  // namespace

Json design_schema() {
  using namespace schema;
  const Json price = object({{"requirement", number(), "its index in the spec"},
                             {"relaxed", number(), "part of the limit by which it is looser"},
                             {"price", number_or_null(), "then; null: none is found, or not stated"},
                             {"bits", number_or_null()},
                             {"proven", boolean()}});
  const Json point = object({{"price", number_or_null()},
                             {"bits", number(), "sum over the joints"},
                             {"quantity", text()},
                             {"value", number_or_null()},
                             {"unit", text()},
                             {"encoders", map(text())},
                             {"proven", boolean()}});
  return object(joined(
      header("design"),
      {{"minimize", text(), "price, resolution, or a quantity"},
       {"price_unit", text(), "of the catalogues; empty: not stated"},
       {"budget", number(), "", true},
       {"optimal", design_choice_schema(), "null: no design meets the requirements"},
       {"runner_up", design_choice_schema()},
       {"proven", boolean(), "whether no better design exists"},
       {"bound", number_or_null(), "of the price (bits), if it is not proven"},
       {"price_of_requirements", list(price)},
       {"pareto", list(point), "by ascending price; minimize: resolution, or a price is missing: by bits"},
       {"finest", design_choice_schema(), "nothing feasible: the design nearest to all limits"},
       {"obstacles", list(text()), "nothing feasible: why"},
       {"left_out", list(text()), "options that cannot count fast enough"},
       {"without_influence", list(number()), "requirements that no option changes"},
       {"warnings", warnings()}}));
}

}  // namespace qerr
