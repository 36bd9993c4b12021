#include "cli/command.hpp"
#include "cli/shared.hpp"

namespace qerr::cli {

namespace {

int run(const Values& v) {
  OutputFile out(v.text("output"));
  finish(out, json_schema());
  return 0;
}

}  // namespace

Command schema_command() {
  return {"schema",
          "The JSON Schema of the spec, for editors",
          {{.name = "-o,--output",
            .value = "FILE",
            .meaning = "write to FILE; '-' is standard output",
            .fallback = "-"}},
          run};
}

}  // namespace qerr::cli
