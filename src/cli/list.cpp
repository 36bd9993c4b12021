#include "cli/command.hpp"
#include "cli/shared.hpp"
#include "core/output_file.hpp"

namespace qerr::cli {

namespace {

std::vector<std::string> kinds() { return list_kinds(); }

int run(const Values& v) {
  OutputFile out(v.text("output"));
  finish(out, list_report(v.text("KIND")), v);
  return 0;
}

}  // namespace

Command list_command() {
  return {"list", "What a spec can contain: effects, filters, encoders, formats, coordinates, statistics",
          joined({{{.name = "KIND",
                    .meaning = "effects, filters, encoders, formats, coordinates or statistics",
                    .required = true,
                    .choices = kinds,
                    .choice = "kind"}},
                  output_options()}),
          run};
}

}  // namespace qerr::cli
