#include "cli/command.hpp"
#include "cli/shared.hpp"

namespace qerr::cli {

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
