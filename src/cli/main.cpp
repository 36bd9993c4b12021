#include <fcntl.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include "cli/command.hpp"
#include "cli/terminal.hpp"
#include "core/output_file.hpp"
#include "core/run_files.hpp"
#include "qerr/core/error.hpp"
#include "report/wrapped_text.hpp"

namespace {

constexpr int closed_pipe_code = 128 + SIGPIPE;

extern "C" void stop(int signal) {
  qerr::remove_unfinished_outputs();
  _exit(128 + signal);
}

/// A result is renamed to its path only when it is complete, so that a signal may end the program at any
/// time.
void set_signals() {
  std::signal(SIGINT, stop);
  std::signal(SIGTERM, stop);
  // The process must remove its temporary files when the reader of its pipe has gone: write() then returns
  // EPIPE.
  std::signal(SIGPIPE, SIG_IGN);
  // A file beyond the limit of the shell (ulimit -f) is an error of write(), too.
  std::signal(SIGXFSZ, SIG_IGN);
}

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
  qerr::cli::clear_progress();
  const std::size_t width = qerr::cli::message_width();
  std::fputs((width > 0 ? qerr::within(text, width) : text + '\n').c_str(), stderr);
  return static_cast<int>(trouble);
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  occupy_standard_streams();
  set_signals();
  const qerr::RunFiles files;
  try {
    return qerr::cli::run_command_line({argv + std::min(argc, 1), argv + argc});
  } catch (const qerr::Error& e) {
    return report(e.what(), e.trouble());
  } catch (const qerr::ClosedPipe&) {
    return closed_pipe_code;
  } catch (const std::bad_alloc&) {
    return report("qerr: out of memory; use fewer configurations or a smaller input",
                  qerr::Trouble::internal);
  } catch (const std::exception& e) {
    return report(std::string("qerr: internal error: ") + e.what(), qerr::Trouble::internal);
  }
}
