#include "cli/shared.hpp"
#include "report/text_table.hpp"

namespace qerr::cli {

namespace {

std::vector<std::string> kinds() { return list_kinds(); }

std::vector<std::string> names_in(const std::string& kind) { return names_of(list_report(kind).rows); }

int run_list(const Values& v) {
  OutputFile out(v.text("output"));
  ListReport report = list_report(v.text("KIND"));
  if (v.given("NAME"))
    std::erase_if(report.rows, [&](const auto& row) { return row.name != v.text("NAME"); });
  finish(out, report, v);
  return 0;
}

}  // namespace

Command list_command() {
  return {"list",
          "What a spec can contain: effects, filters, encoders, coordinates, quantities, units, ...",
          joined({{valued("KIND", "",
                          "effects, filters, estimators, encoders, formats, coordinates, statistics, "
                          "quantities or units")
                       .one_of(kinds, "kind")
                       .must(),
                   {.name = "NAME",
                    .meaning = "only this one of them",
                    .choice = "name",
                    .choices_behind = names_in}},
                  output_options_without_page()}),
          run_list,
          {{"qerr list effects", "every deviation of a real robot from the ideal model, with its parameters"},
           {"qerr list filters kalman", "one filter, with its parameters, units, ranges and defaults"},
           {"qerr list quantities", "the figures that requirements may limit"},
           {"qerr list encoders --format json", "the same for a program"}},
          {"encoders", "filters", "effects", "requirements"}};
}

namespace {

std::vector<std::string> reports() { return output_schema_names(); }

int run_schema(const Values& v) {
  OutputFile out(v.text("output"));
  finish(out, v.given("output-of") ? output_schema(v.text("output-of")) : json_schema());
  return 0;
}

}  // namespace

Command schema_command() {
  return {"schema",
          "The JSON Schema of the spec, for editors, or of a command's JSON report",
          {valued("--output-of", "REPORT", "of the JSON that this command writes; plan is diagnose --plan")
               .one_of(reports, "report"),
           text_output_option(".json .txt")},
          run_schema,
          {{"qerr schema -o qerr.schema.json", "of the spec, for an editor that completes and checks it"},
           {"qerr schema --output-of analyze", "of the report of analyze (draft 2020-12)"}},
          {"spec", "output"}};
}

}  // namespace qerr::cli
