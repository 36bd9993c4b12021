#include "cli/command.hpp"

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "core/suggest.hpp"

namespace qerr::cli {

namespace {

std::vector<std::string> format_names() {
  std::vector<std::string> names;
  for (const Format& f : formats()) names.emplace_back(f.name);
  return names;
}

Error usage(const std::string& key, const std::string& rule, const std::string& found,
            const std::string& remedy) {
  return Error({{"", 0, 0}, key, rule, found, remedy}, Trouble::usage);
}

}  // namespace

const std::vector<Command>& commands() {
  static const std::vector<Command> table{
      {"analyze", "Worst-case and IPQN bounds of position, velocity, acceleration over the configurations",
       declare_analyze},
      {"check", "Hold the spec's requirements against the figures; exit code 1 when one is not met",
       declare_check},
      {"filter", "Every filter: norms, delay, bandwidth, settling, fidelity, responses", declare_filter},
      {"simulate", "Explicit quantizers along the motion: a log, and theory beside simulation",
       declare_simulate},
      {"diagnose", "What is wrong with a measured log: named causes, an extended model, the gain",
       declare_diagnose},
      {"threshold", "Resolution and threshold velocity, one row per robot (Table IV)", declare_threshold},
      {"list", "What can be written in a spec: effects, filters, encoders, formats, coordinates",
       declare_list},
      {"schema", "The JSON Schema of the spec, for editors", declare_schema},
  };
  return table;
}

void add_output_options(CLI::App& app, Options& o) {
  app.add_option("--format", o.format, "table, json or csv (default: by the output's ending, else table)")
      ->type_name("FORMAT")
      ->check([](const std::string& text) {
        const std::vector<std::string> names = format_names();
        for (const std::string& name : names)
          if (name == text) return std::string();
        return "'" + text + "' is no format; " + did_you_mean(text, names);
      });
  app.add_option("-o,--output", o.output, "write to FILE; '-' is standard output")->type_name("FILE");
  app.add_flag("--quiet,-q", o.quiet, "no warnings, no progress");
  app.add_flag("--no-color", o.no_color, "no colours");
}

void add_spec_options(CLI::App& app, Options& o) {
  app.add_option("--set", o.set, "override one value of the spec, e.g. encoders.elbow.bits=19")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false)
      ->take_all();
  app.add_option("--seed", o.seed, "seed of all that is drawn: configurations, phases, noise")
      ->type_name("N")
      ->check([](const std::string& text) {
        const auto seed = parse_number(text);
        const bool whole = seed && *seed >= 0 && *seed <= 0x1p53 && *seed == std::floor(*seed);
        return whole ? std::string() : "'" + text + "' is not a whole number from 0 to 2^53";
      });
  app.add_option("--threads", o.threads, "threads (default: one per core); the results do not depend on it")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
}

Spec load(const std::string& path, const Options& o) {
  SpecOverrides overrides;
  for (const std::string& text : o.set) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw usage("--set", "must be KEY=VALUE", "'" + text + "'", "e.g. --set encoders.elbow.bits=19");
    overrides.values.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  if (!o.seed.empty()) overrides.seed = static_cast<std::uint64_t>(*parse_number(o.seed));
  return read_spec(path, overrides);
}

std::string chosen_format(const Options& o) {
  if (!o.format.empty()) return o.format;
  for (const Format& f : formats())
    if (o.output.ends_with(f.ending)) return std::string(f.name);
  return "table";
}

Style style(const Options& o) {
  const char* no_color = std::getenv("NO_COLOR");
  const char* term = std::getenv("TERM");
  const bool dumb = term && std::string_view(term) == "dumb";
  return {o.output == "-" && isatty(STDOUT_FILENO) && !o.no_color && !(no_color && *no_color) && !dumb};
}

void warn(const std::vector<std::string>& warnings, const Options& o) {
  if (o.quiet) return;
  for (const std::string& text : warnings) std::fprintf(stderr, "warning: %s\n", escaped(text, 600).c_str());
}

std::function<void(std::uint64_t, std::uint64_t)> progress(const Options& o) {
  if (o.quiet || !isatty(STDERR_FILENO)) return {};
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  auto shown = std::make_shared<Clock::time_point>(start);
  auto visible = std::make_shared<bool>(false);
  return [=](std::uint64_t done, std::uint64_t total) {
    const auto now = Clock::now();
    if (done == total) {
      if (*visible) std::fputs("\r\x1b[K", stderr);
    } else if (now - *shown > std::chrono::milliseconds(100)) {
      *shown = now;
      *visible = true;
      std::fprintf(stderr, "\r%3.0f %% of %llu",
                   100.0 * static_cast<double>(done) / static_cast<double>(total),
                   static_cast<unsigned long long>(total));
    }
  };
}

}  // namespace qerr::cli
