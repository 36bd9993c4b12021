#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <list>
#include <memory>
#include <string>

#include "cli/command.hpp"
#include "cli/shared.hpp"
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
std::atomic<const std::string*> on_interrupt = nullptr;

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

namespace {

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
