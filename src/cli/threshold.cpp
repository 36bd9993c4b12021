#include <memory>

#include "cli/command.hpp"
#include "core/output_file.hpp"
#include "qerr/report/threshold_row.hpp"

namespace qerr::cli {

std::function<int()> declare_threshold(CLI::App& app, Options& o) {
  auto specs = std::make_shared<std::vector<std::string>>();
  app.add_option("SPEC", *specs, "one spec per robot")->required();
  add_spec_options(app, o);
  add_output_options(app, o);
  return [=, &o] {
    std::vector<ThresholdRow> rows;
    for (const std::string& path : *specs) {
      const Spec spec = load(path, o);
      warn(spec.warnings, o);
      rows.push_back(threshold_row(spec, o.threads));
    }
    OutputFile out(o.output);
    out.write(write(rows, chosen_format(o), style(o)));
    out.close();
    return 0;
  };
}

}  // namespace qerr::cli
