#include "cli/terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "cli/caller.hpp"
#include "core/text.hpp"
#include "qerr/core/quantity.hpp"
#include "report/text_table.hpp"

namespace qerr::cli {

namespace {

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
    std::transform(locale.begin(), locale.end(), locale.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
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

}  // namespace

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

std::function<void(std::uint64_t, std::uint64_t)> progress(const Values& v, std::string_view noun) {
  if (Caller* by = caller())
    return [by](std::uint64_t, std::uint64_t) {
      if (by->stops) throw Stopped();
    };
  const std::string& when = v.text("progress");
  const bool terminal = isatty(STDERR_FILENO);
  if (when == "never" || (when == "auto" && (v.given("quiet") || !terminal))) return {};
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const auto last_shown = std::make_shared<Clock::time_point>(start);
  return [=, noun = std::string(noun)](std::uint64_t done, std::uint64_t total) {
    const auto now = Clock::now();
    if (done >= total) return clear_progress();
    // The rate of the first moment misleads.
    if (done == 0 || now - start < std::chrono::milliseconds(300) ||
        now - *last_shown < std::chrono::milliseconds(terminal ? 100 : 1000))
      return;
    *last_shown = now;
    const double rate = static_cast<double>(done) / std::chrono::duration<double>(now - start).count();
    const double part = static_cast<double>(done) / static_cast<double>(total);
    const std::string line = fixed_point(100 * part, 0) + " % of " + amount(static_cast<double>(total)) +
                             (noun.empty() ? "" : ' ' + noun) + ", " + readable(rate, "/s") + ", " +
                             duration(static_cast<double>(total - done) / rate) + " left";
    std::fprintf(stderr, terminal ? "\r%s\x1b[K" : "%s\n", line.c_str());
    std::fflush(stderr);
    progress_is_visible = terminal;
  };
}

}  // namespace qerr::cli
