#include "cli/shared.hpp"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>

namespace qerr::cli {

namespace {

std::vector<std::string> format_names() {
  std::vector<std::string> names;
  for (const Format& format : formats()) names.emplace_back(format.name);
  return names;
}

}  // namespace

std::vector<Option> spec_options(std::string_view meaning) {
  return {{.name = "SPEC", .meaning = meaning, .required = true},
          {.name = "--set",
           .value = "KEY=VALUE",
           .kind = OptionKind::repeat,
           .meaning = "override one value of the spec, e.g. encoders.elbow.bits=19"},
          {.name = "--seed",
           .value = "N",
           .kind = OptionKind::whole,
           .meaning = "seed of all random numbers: configurations, phases, noise",
           .least = 0,
           .most = 0x1p53},
          {.name = "--threads",
           .value = "N",
           .kind = OptionKind::whole,
           .meaning = "threads (default: one per core); the results do not depend on it",
           .least = 1,
           .most = 1024}};
}

std::vector<Option> output_options() {
  return {{.name = "--format",
           .value = "FORMAT",
           .meaning = "table, json or csv (default: by the output's ending, else table)",
           .choices = format_names,
           .choice = "format"},
          {.name = "-o,--output",
           .value = "FILE",
           .meaning = "write to FILE; '-' is standard output",
           .fallback = "-"},
          {.name = "-q,--quiet", .kind = OptionKind::flag, .meaning = "no warnings, no progress"},
          {.name = "--no-color", .kind = OptionKind::flag, .meaning = "no colours"}};
}

std::vector<Option> joined(std::initializer_list<std::vector<Option>> groups) {
  std::vector<Option> all;
  for (const std::vector<Option>& group : groups) all.insert(all.end(), group.begin(), group.end());
  return all;
}

Error usage(const std::string& option, const std::string& rule, const std::string& found,
            const std::string& remedy) {
  return Error({{}, option, rule, found, remedy}, Trouble::usage);
}

Spec load(const std::string& path, const Values& v) {
  SpecOverrides overrides;
  for (const std::string& text : v.texts("set")) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw usage("--set", "must be KEY=VALUE", "'" + text + "'", "e.g. --set encoders.elbow.bits=19");
    overrides.values.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  if (v.given("seed")) overrides.seed = v.whole("seed");
  return read_spec(path, overrides);
}

unsigned threads(const Values& v) {
  return v.given("threads") ? static_cast<unsigned>(v.whole("threads")) : 0;
}

std::string chosen_format(const Values& v) {
  return v.given("format") ? v.text("format") : std::string(format_of(v.text("output")));
}

Style style(const Values& v) {
  const char* no_color = std::getenv("NO_COLOR");
  const char* term = std::getenv("TERM");
  const bool dumb = term && std::string_view(term) == "dumb";
  return {v.text("output") == "-" && isatty(STDOUT_FILENO) && !v.given("no-color") &&
          !(no_color && *no_color) && !dumb};
}

void warn(const std::vector<std::string>& warnings, const Values& v) {
  if (v.given("quiet")) return;
  for (const std::string& text : warnings) std::fprintf(stderr, "warning: %s\n", escaped(text, 600).c_str());
}

std::function<void(std::uint64_t, std::uint64_t)> progress(const Values& v) {
  if (v.given("quiet") || !isatty(STDERR_FILENO)) return {};
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  auto last_shown = std::make_shared<Clock::time_point>(start);
  auto visible = std::make_shared<bool>(false);
  return [=](std::uint64_t done, std::uint64_t total) {
    const auto now = Clock::now();
    if (done == total) {
      if (*visible) std::fputs("\r\x1b[K", stderr);
    } else if (now - *last_shown > std::chrono::milliseconds(100)) {
      *last_shown = now;
      *visible = true;
      std::fprintf(stderr, "\r%3.0f %% of %llu",
                   100.0 * static_cast<double>(done) / static_cast<double>(total),
                   static_cast<unsigned long long>(total));
    }
  };
}

}  // namespace qerr::cli
