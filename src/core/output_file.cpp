#include "core/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>

#include "core/run_files.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

namespace {

constexpr std::size_t buffer_size = std::size_t{1} << 16;

/// Names of temporary files in static storage for the signal handler; the flag is set last and cleared first.
struct Unfinished {
  volatile std::sig_atomic_t used = 0;
  char path[4096] = {};
};
std::array<Unfinished, 8> unfinished;

int remember(const std::string& path) {
  for (std::size_t i = 0; i < unfinished.size(); ++i) {
    if (unfinished[i].used || path.size() >= sizeof unfinished[i].path) continue;
    std::memcpy(unfinished[i].path, path.c_str(), path.size() + 1);
    unfinished[i].used = 1;
    return static_cast<int>(i);
  }
  return -1;
}

void forget(int slot) {
  if (slot >= 0) unfinished[static_cast<std::size_t>(slot)].used = 0;
}

bool is_special(const std::string& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode);
}

}  // namespace

void remove_unfinished_outputs() {
  for (const Unfinished& output : unfinished)
    if (output.used) unlink(output.path);
}

OutputFile::OutputFile(std::string path, const std::string& option) : path_(std::move(path)) {
  note_output(path_, option);
  if (path_ == "-") {
    descriptor_ = STDOUT_FILENO;
    return;
  }
  if (is_special(path_)) {
    descriptor_ = open(path_.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    // Symbolic links are resolved, so that their target is replaced and not the link.
    std::error_code ignored;
    const auto real = std::filesystem::canonical(path_, ignored);
    const std::string target = ignored ? path_ : real.string();
    if (!ignored) path_ = target;
    temporary_ = target + ".tmp." + std::to_string(getpid());
    descriptor_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  }
  if (descriptor_ >= 0 && !temporary_.empty()) slot_ = remember(temporary_);
  if (descriptor_ < 0) {
    temporary_.clear();
    fail("cannot be opened for writing", errno);
  }
}

OutputFile::~OutputFile() {
  if (descriptor_ > STDERR_FILENO) ::close(descriptor_);
  if (!temporary_.empty()) unlink(temporary_.c_str());
  forget(slot_);
}

void OutputFile::fail(const std::string& what, int code) {
  throw Error(
      Fault{{path_ == "-" ? "standard output" : path_, 0, 0}, "", what + ": " + std::strerror(code), "", ""},
      Trouble::file_system);
}

void OutputFile::write(std::string_view text) {
  buffer_ += text;
  if (buffer_.size() >= buffer_size) flush();
}

void OutputFile::flush() {
  for (std::size_t done = 0; done < buffer_.size();) {
    const ssize_t n = ::write(descriptor_, buffer_.data() + done, buffer_.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EPIPE) throw ClosedPipe{};
    if (n < 0) fail("cannot be written", errno);
    done += static_cast<std::size_t>(n);
  }
  buffer_.clear();
}

void OutputFile::close() {
  flush();
  if (descriptor_ == STDOUT_FILENO) return;
  if (!temporary_.empty() && fsync(descriptor_) != 0) fail("cannot be written", errno);
  const int closed = ::close(descriptor_);
  descriptor_ = -1;
  if (closed != 0) fail("cannot be written", errno);
  if (temporary_.empty()) return;
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) fail("cannot be replaced", errno);
  temporary_.clear();
}

}  // namespace qerr
