#include "cli/shared.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <list>

#include "core/run_files.hpp"
#include "core/text.hpp"
#include "input/joint_entries.hpp"
#include "input/read_sections.hpp"
#include "qerr/core/quantity.hpp"
#include "report/text_table.hpp"

namespace qerr::cli {

namespace {

std::vector<std::string> all_formats() { return names_of(formats()); }

std::vector<std::string> format_names() {
  std::vector<std::string> names = all_formats();
  std::erase(names, "md");
  return names;
}

std::vector<std::string> format_names_without_page() {
  std::vector<std::string> names = format_names();
  std::erase(names, "html");
  return names;
}

/// Dotted paths that shells propose for --set: sections, their keys, and those of encoders under a pattern.
std::vector<std::string> keys_of_spec() {
  std::vector<std::string> keys;
  const auto add = [&](const std::string& section, const std::vector<Parameter>& rows) {
    for (const Parameter& row : rows) keys.push_back(section + std::string(row.name));
  };
  add("", spec_format::top);
  add("robot.", spec_format::robot);
  for (const char* const section : {"robot.tool.", "robot.tracker."}) add(section, spec_format::pose);
  for (const std::string& key : encoder_keys()) keys.push_back("encoders.*." + key);
  add("configurations.", spec_format::configurations);
  add("motion.", spec_format::motion);
  add("control.", spec_format::control);
  add("log.", spec_format::log);
  add("design.", spec_format::design);
  return keys;
}

/// Refuses an ending that an output of one format, such as FILE.csv, does not have.
void require_own_endings(const std::vector<Option>& of_command, const Values& v) {
  for (const Option& option : of_command) {
    const std::string ending = std::filesystem::path(v.text(option.key())).extension().string();
    const std::string known(option.value == "FILE.csv" ? ".csv .txt" : option.endings);
    if (known.empty() || ending.empty() || (' ' + known + ' ').find(' ' + ending + ' ') != std::string::npos)
      continue;
    throw usage(option.long_name(), "this output has no format with the ending", quoted(ending),
                "known: " + known + ", or none");
  }
}

constexpr std::size_t least_width = 40, usual_width = 80, largest_width = 1000;

std::string environment(const char* name) {
  const char* text = std::getenv(name);
  return text ? text : "";
}

/// COLUMNS, else that of the terminal behind the stream, else `otherwise`.
std::size_t terminal_width(int stream, bool on_terminal, std::size_t otherwise) {
  const auto columns = parse_number(environment("COLUMNS"));
  if (columns && *columns >= least_width && *columns <= largest_width)
    return static_cast<std::size_t>(*columns);
  struct winsize size {};
  const bool known = on_terminal && ioctl(stream, TIOCGWINSZ, &size) == 0 && size.ws_col >= least_width;
  return known ? size.ws_col : otherwise;
}

bool colored(const Values& v, bool on_terminal) {
  if (v.given("no-color") || v.text("color") == "never") return false;
  if (v.text("color") == "always") return true;
  return on_terminal && environment("NO_COLOR").empty() && environment("TERM") != "dumb";
}

/// Whether the locale's characters are UTF-8, by the variables of POSIX in their order of precedence.
bool locale_is_utf8() {
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    std::string locale = environment(name);
    if (locale.empty()) continue;
    std::ranges::transform(locale, locale.begin(), [](char c) {
      return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    return locale.find("utf-8") != std::string::npos || locale.find("utf8") != std::string::npos;
  }
  return false;
}

/// `4000`, `20.0 M`.
std::string amount(double count) {
  if (count < 1e5) return significant(count, 6);
  std::string text = readable(count, "x");
  text.pop_back();  // a prefix without a unit
  return text;
}

std::atomic<bool> progress_is_visible = false;
std::atomic<const std::string*> on_interrupt = nullptr;

using Clock = std::chrono::steady_clock;

/// A line on standard error that is written anew while work goes on; where the program runs within another
/// one, the place where that one stops the work.
class ProgressLine {
 public:
  explicit ProgressLine(const Values& v) : by_(caller()), terminal_(isatty(STDERR_FILENO)) {
    const std::string& when = v.text("progress");
    silent_ = when == "never" || (when == "auto" && (v.given("quiet") || !terminal_));
  }
  bool is_needed() const { return by_ || !silent_; }
  double elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  /// Whether it is time for the next line. The rate of the first moment misleads.
  /// @throws Stopped if the caller has stopped the work
  bool is_due() {
    if (by_ && by_->stops) throw Stopped();
    const auto now = Clock::now();
    if (by_ || now - start_ < std::chrono::milliseconds(300) ||
        now - shown_ < std::chrono::milliseconds(terminal_ ? 100 : 1000))
      return false;
    shown_ = now;
    return true;
  }

  void show(const std::string& line) const {
    std::fprintf(stderr, terminal_ ? "\r%s\x1b[K" : "%s\n", line.c_str());
    std::fflush(stderr);
    progress_is_visible = terminal_;
  }

 private:
  Caller* by_;
  bool terminal_, silent_ = false;
  Clock::time_point start_ = Clock::now(), shown_ = start_;
};

}  // namespace

std::vector<Option> spec_options(std::string_view meaning) {
  return {
      valued("SPEC", "", meaning).must(),
      {.name = "--set",
       .value = "KEY=VALUE",
       .kind = OptionKind::repeat,
       .meaning = "override one value of the spec, e.g. encoders.elbow.bits=19",
       .choices = keys_of_spec,
       .open = true},
      valued("--seed", "N", "seed of all random numbers: configurations, phases, noise", OptionKind::whole)
          .within(0, 0x1p53 - 1),
      valued("--threads", "N", "threads (default: one per core); the results do not depend on it",
             OptionKind::whole)
          .within(1, 1024)};
}

std::vector<Option> output_options() {
  return {
      valued("--format", "FORMAT", "table, json, csv or html (default: by the output's ending, else table)")
          .one_of(format_names, "format"),
      text_output_option(),
      {.name = "--json",
       .kind = OptionKind::flag,
       .meaning = "the same as --format json",
       .stands_for = "--format=json"}};
}

std::vector<Option> output_options_without_page() {
  std::vector<Option> options = output_options();
  options.front().meaning = "table, json or csv (default: by the output's ending, else table)";
  options.front().choices = format_names_without_page;
  return options;
}

std::vector<Option> long_work_option() {
  return {flag("--allow-long", "permit more than 1e10 configurations or samples, which take hours")};
}

Option prove_option(std::string_view meaning) {
  return {.name = "--prove",
          .value = "[GAP]",
          .kind = OptionKind::optional,
          .meaning = meaning,
          .is_value =
              [](const std::string& word) {
                std::string why;
                return parse_quantity(word, why).has_value();
              },
          .implied = "1%"};
}

double part_of(const Values& v, const std::string& option, double least, double most, const std::string& rule,
               const std::string& remedy) {
  std::string why;
  const auto value = parse_quantity(v.text(option), why);
  if (value && value->value >= least && value->value <= most &&
      value->dimension.value_or(dimension::none) == dimension::none)
    return value->value;
  throw usage("--" + option, rule, quoted(v.text(option)), remedy);
}

ProofRequest proof_request(const Values& v) {
  ProofRequest request;
  request.progress = progress(v, "proofs");
  constexpr double finest = 1e-5, coarsest = 1;
  if (v.given("prove"))
    request.gap = part_of(v, "prove", finest, coarsest, "the gap must be a part from 0.001% to 100%",
                          "e.g. --prove 0.5%, or 0.005");
  return request;
}

std::vector<Option> output_options_with_markdown() {
  std::vector<Option> options = output_options();
  options.front().meaning =
      "table, json, csv, html, or md for a job's summary (default: by the output's ending, else table)";
  options.front().choices = all_formats;
  return options;
}

Option text_output_option(std::string_view endings) {
  return {.name = "-o,--output",
          .value = "FILE",
          .meaning = "write to FILE; '-' is standard output",
          .fallback = "-",
          .endings = endings};
}

std::vector<Option> joined(std::initializer_list<std::vector<Option>> groups) {
  std::vector<Option> all;
  for (const std::vector<Option>& group : groups) all.insert(all.end(), group.begin(), group.end());
  return all;
}

Error usage(const std::string& option, const std::string& rule, const std::string& found,
            const std::string& remedy) {
  return Error(option, rule, found, remedy, Trouble::usage);
}

SpecOverrides overrides(const Values& v) {
  SpecOverrides changes;
  for (const std::string& text : v.texts("set")) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw usage("--set", "must be KEY=VALUE", "'" + text + "'", "e.g. --set encoders.elbow.bits=19");
    const std::string key = text.substr(0, equals);
    for (const auto& [other, value] : changes.values)
      // A later change may refine an earlier one: of a key within it.
      if (set_one_value(key, other) && !(key.starts_with(other + '.') || key.starts_with(other + '[')))
        throw usage("--set",
                    key == other ? "sets " + key + " twice" : other + " governs nothing: " + key + " follows",
                    quoted(value) + " and " + quoted(text.substr(equals + 1)), "give one of the two");
    changes.values.emplace_back(key, text.substr(equals + 1));
  }
  if (v.given("seed")) changes.seed = v.whole("seed");
  return changes;
}

Spec load(const std::string& path, const Values& v, const std::vector<std::string_view>& unused,
          const ReportText& report) {
  const SpecOverrides changes = overrides(v);
  Spec spec = read_spec(path, changes);
  append(spec.warnings, idle_overrides(spec, changes, unused, report));
  return spec;
}

void refuse_shared_input(const std::vector<std::string>& paths, const std::string& option) {
  if (std::ranges::count(paths, "-") > 1)
    throw usage(option, "only one input can be standard input", "'-'", "name the others as files");
}

WorkspaceOptions workspace_options(const Values& v) {
  WorkspaceOptions options;
  options.threads = threads(v);
  options.progress = progress(v, "configurations");
  return options;
}

unsigned threads(const Values& v) {
  return v.given("threads") ? static_cast<unsigned>(v.whole("threads")) : 0;
}

std::string chosen_format(const Values& v) {
  return v.given("format") ? v.text("format") : std::string(format_of(v.text("output")));
}

Style style(const Values& v) { return terminal_style(v, v.text("output") == "-"); }

std::unique_ptr<OutputFile> opened(const Values& v, const std::string& option) {
  const std::string& path = v.text(option);
  return path.empty() ? nullptr : std::make_unique<OutputFile>(path, "--" + option);
}

std::unique_ptr<OutputFile> opened_report(const Values& v, std::initializer_list<const char*> others) {
  const bool taken = std::ranges::any_of(others, [&](const char* o) { return v.text(o) == "-"; });
  return taken && !v.given("output") && !v.given("format") ? nullptr : opened(v, "output");
}

void require_known_ending(const std::vector<Option>& of_command, const Values& v) {
  require_own_endings(of_command, v);
  const auto format =
      std::ranges::find_if(of_command, [](const Option& option) { return option.key() == "format"; });
  if (format == of_command.end() || v.given("format")) return;
  const std::string ending = std::filesystem::path(v.text("output")).extension().string();
  const std::vector<std::string> known = format->choices();
  std::string endings;
  for (const Format& row : formats()) {
    if (!contains(known, row.name)) continue;
    if (ending.empty() || ending == row.ending) return;
    endings += (endings.empty() ? "" : ", ") + std::string(row.ending);
  }
  throw usage("--output", "no format of this command has the ending", quoted(ending),
              "known: " + endings + "; or choose one with --format");
}

void finish(OutputFile& file, const std::string& text) {
  file.write(text);
  file.close();
}

void finish_spec(OutputFile& file, const std::string& text, const std::string& path) {
  finish(file, text);
  note_as_written(path);
}

void limit_work(const Spec& spec, double amount, const std::string& key, const std::string& noun,
                const Values& v, double rate) {
  constexpr double most = 1e10;
  if (amount <= most || v.given("allow-long")) return;
  throw Error({spec.file}, key, "more than 1e10 " + noun + " need --allow-long",
              significant(amount, 3) + ", which take about " + duration(amount / rate) + " at " +
                  readable_number(rate) + " a second",
              "add --allow-long, or make them fewer");
}

void limit_configurations(const Spec& spec, const Values& v) {
  limit_work(spec, static_cast<double>(size(spec.configurations)), "configurations.count", "configurations",
             v);
}

void warn(const std::vector<std::string>& warnings, const Values& v) {
  if (caller()) caller()->warnings.insert(caller()->warnings.end(), warnings.begin(), warnings.end());
  if (caller() || v.given("quiet")) return;
  clear_progress();
  const std::size_t width = message_width();
  for (std::size_t i = 0; i < warnings.size(); ++i) {
    const std::string& warning = warnings[i];
    if (std::find(warnings.begin(), warnings.begin() + i, warning) != warnings.begin() + i) continue;  // said
    const std::string text = "warning: " + escaped(warning, 600);
    std::fputs((width > 0 ? wrapped(text, width, "  ", "") : text + '\n').c_str(), stderr);
  }
}

void warn(const SpecWarnings& of_specs, const Values& v) {
  if (of_specs.size() == 1) return warn(of_specs.front().second, v);
  ItemGroups specs;  // that have a warning
  for (const auto& [file, warnings] : of_specs)
    for (const std::string& warning : warnings) add_to_group(specs, warning, file);
  std::vector<std::string> named;
  for (const auto& [warning, files] : specs) named.push_back(qerr::joined(files) + ": " + warning);
  warn(named, v);
}

std::string duration(double seconds) {
  const auto whole = static_cast<std::uint64_t>(std::llround(std::min(seconds, 1e15)));
  const std::uint64_t minutes = whole / 60, hours = minutes / 60;
  if (minutes == 0) return std::to_string(whole) + " s";
  if (hours >= 72) return std::to_string(hours / 24) + " days";
  if (hours == 0) return std::to_string(minutes) + " min " + std::to_string(whole % 60) + " s";
  return std::to_string(hours) + " h " + std::to_string(minutes % 60) + " min";
}

Style terminal_style(const Values& v, bool on_standard_output) {
  const bool on_terminal = on_standard_output && isatty(STDOUT_FILENO);
  Style style;
  style.color = colored(v, on_terminal);
  style.width = terminal_width(STDOUT_FILENO, on_terminal, usual_width);
  style.ascii = !locale_is_utf8();
  return style;
}

std::size_t message_width() { return terminal_width(STDERR_FILENO, isatty(STDERR_FILENO), 0); }

void clear_progress() {
  if (progress_is_visible.exchange(false)) std::fputs("\r\x1b[K", stderr);
}

void print_error(const std::string& text) {
  if (caller()) return caller()->warnings.push_back(text);
  clear_progress();
  const std::size_t width = message_width();
  std::fputs((width > 0 ? within(text, width) : text + '\n').c_str(), stderr);
}

std::string_view interrupt_message() noexcept {
  if (const std::string* said = on_interrupt) return *said;
  return "\nqerr: stopped; unfinished files are removed\n";
}

void say_on_interrupt(const std::string& how_to_go_on) {
  static std::list<std::string> all;  // a signal may be reading the one before
  on_interrupt = &all.emplace_back("\nqerr: stopped; " + how_to_go_on + '\n');
}

std::function<void(std::uint64_t, std::uint64_t)> progress(const Values& v, std::string_view noun) {
  const auto line = std::make_shared<ProgressLine>(v);
  if (!line->is_needed()) return {};
  return [line, noun = std::string(noun)](std::uint64_t done, std::uint64_t total) {
    const bool due = line->is_due();
    if (done >= total) return clear_progress();
    if (done == 0 || !due) return;
    const double rate = static_cast<double>(done) / line->elapsed();
    const double part = static_cast<double>(done) / static_cast<double>(total);
    line->show(fixed_point(100 * part, 0) + " % of " + amount(static_cast<double>(total)) +
               (noun.empty() ? "" : ' ' + noun) + ", " + readable(rate, "/s") + ", " +
               duration(static_cast<double>(total - done) / rate) + " left");
  };
}

std::function<void(std::size_t, double)> search_progress(const Values& v) {
  const auto line = std::make_shared<ProgressLine>(v);
  if (!line->is_needed()) return {};
  return [line](std::size_t search, double part) {
    if (line->is_due())
      line->show("search " + std::to_string(search) + ", " + fixed_point(100 * std::min(part, 1.0), 0) +
                 " % of its work at most, " + duration(line->elapsed()));
  };
}

}  // namespace qerr::cli
