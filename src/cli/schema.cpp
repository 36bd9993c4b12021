#include "cli/command.hpp"
#include "cli/shared.hpp"
#include "core/output_file.hpp"

namespace qerr::cli {

namespace {

int run(const Values& v) {
  OutputFile out(v.text("output"));
  out.write(json_schema());
  out.close();
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
