#include <memory>

#include "cli/command.hpp"
#include "core/output_file.hpp"
#include "core/suggest.hpp"

namespace qerr::cli {

std::function<int()> declare_list(CLI::App& app, Options& o) {
  auto kind = std::make_shared<std::string>();
  app.add_option("KIND", *kind, "effects, filters, encoders, formats, coordinates or statistics")
      ->required()
      ->check([](const std::string& text) {
        for (const std::string& known : list_kinds())
          if (known == text) return std::string();
        return "'" + text + "' is no kind; " + did_you_mean(text, list_kinds());
      });
  add_output_options(app, o);
  return [=, &o] {
    OutputFile out(o.output);
    out.write(write_list(*kind, chosen_format(o)));
    out.close();
    return 0;
  };
}

std::function<int()> declare_schema(CLI::App& app, Options& o) {
  app.add_option("-o,--output", o.output, "write to FILE; '-' is standard output")->type_name("FILE");
  return [&o] {
    OutputFile out(o.output);
    out.write(json_schema());
    out.close();
    return 0;
  };
}

}  // namespace qerr::cli
