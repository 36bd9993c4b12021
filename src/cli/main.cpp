#include <fcntl.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <csignal>
#include <exception>
#include <new>
#include <string>
#include <string_view>

#include "cli/shared.hpp"
#include "core/output_file.hpp"
#include "core/run_files.hpp"
#include "qerr/core/error.hpp"

namespace {

constexpr int closed_pipe_code = 128 + SIGPIPE;

/// @param signal  Ctrl-C leaves its `^C` or a line of progress where the shell's prompt would stand
extern "C" void stop(int signal) {
  qerr::remove_unfinished_outputs();
  if (signal == SIGINT && isatty(STDERR_FILENO)) {
    const std::string_view text = qerr::cli::interrupt_message();
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
  }
  _exit(128 + signal);
}

/// A result is renamed to its path only when it is complete, so that a signal may end the program at any
/// time.
void set_signals() {
  std::signal(SIGINT, stop);
  std::signal(SIGTERM, stop);
  // The others that end a process, unless the caller has them ignored, as nohup does.
  for (const int signal : {SIGHUP, SIGQUIT, SIGXCPU, SIGALRM, SIGVTALRM, SIGPROF, SIGUSR1, SIGUSR2})
    if (std::signal(signal, stop) == SIG_IGN) std::signal(signal, SIG_IGN);
  // The process must remove its temporary files when the reader of its pipe has gone: write() then returns
  // EPIPE.
  std::signal(SIGPIPE, SIG_IGN);
  // A file beyond the limit of the shell (ulimit -f) is an error of write(), too.
  std::signal(SIGXFSZ, SIG_IGN);
}

/// Allocates nothing.
int report_out_of_memory() noexcept {
  constexpr std::string_view text = "qerr: out of memory; use fewer configurations or a smaller input\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
  return static_cast<int>(qerr::Trouble::internal);
}

/// Where an exception cannot be caught: memory may end in a constructor before main, or while another
/// exception is on its way.
[[noreturn]] void end_without_abort() noexcept {
  qerr::remove_unfinished_outputs();
  try {
    if (const std::exception_ptr failure = std::current_exception()) std::rethrow_exception(failure);
  } catch (const std::bad_alloc&) {
    _exit(report_out_of_memory());
  } catch (...) {
  }
  constexpr std::string_view text = "qerr: internal error: an exception was not handled\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
  _exit(static_cast<int>(qerr::Trouble::internal));
}

void set_terminate(int, char**, char**) { std::set_terminate(end_without_abort); }

/// Called before the constructors of the libraries (ELF's preinit array).
[[gnu::section(".preinit_array"), gnu::used]] void (*const at_start)(int, char**, char**) = set_terminate;

/// Occupies the standard streams that the caller has closed, so that no file is opened as one of them.
/// Reading from /dev/null that is open for writing fails, and the other way round.
void occupy_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0) open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

/// Columns of long logs come and go: memory that has been freed is used again in place of new pages, whose
/// first use took a third of the time.
void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int gibibyte = 1 << 30;
  mallopt(M_MMAP_THRESHOLD, gibibyte);
  mallopt(M_TRIM_THRESHOLD, gibibyte);
  mallopt(M_ARENA_MAX, 1);  // what the reader has freed serves the threads, too
#endif
}

int report(const std::string& text, qerr::Trouble trouble) {
  qerr::cli::print_error(text);
  return static_cast<int>(trouble);
}

int run(int argc, char** argv) {
  try {
    return qerr::cli::run_command_line({argv + std::min(argc, 1), argv + argc});
  } catch (const qerr::Error& e) {
    return report(e.what(), e.trouble());
  } catch (const qerr::ClosedPipe&) {
    return closed_pipe_code;
  } catch (const std::bad_alloc&) {
    return report_out_of_memory();
  } catch (const std::length_error&) {  // of a container that no memory could hold
    return report_out_of_memory();
  } catch (const std::exception& e) {
    return report(std::string("qerr: internal error: ") + e.what(), qerr::Trouble::internal);
  }
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  occupy_standard_streams();
  set_signals();
  const qerr::RunFiles files;
  try {
    return run(argc, argv);
  } catch (...) {  // the message of an error needs memory, too
    return report_out_of_memory();
  }
}
