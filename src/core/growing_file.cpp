#include "core/growing_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <tuple>

#include "core/output_file.hpp"
#include "core/run_files.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

namespace {

constexpr const char* note_name = "user.qerr";

}  // namespace

GrowingFile::GrowingFile(std::string path, const std::string& option, bool keep) : path_(std::move(path)) {
  note_output(path_, option);
  if (path_ == "-") {
    descriptor_ = STDOUT_FILENO;
    return;
  }
  struct stat status {};
  const bool special = stat(path_.c_str(), &status) == 0 && !S_ISREG(status.st_mode);
  descriptor_ = open(path_.c_str(), special ? O_WRONLY | O_CLOEXEC : O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail("cannot be opened for writing", errno);
  regular_ = fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode);
  if (!regular_) return;
  // File systems without locks are used without them.
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    throw Error(Fault{{path_},
                      option,
                      "another process is writing this file",
                      "",
                      "wait for it, or give the output another name"},
                Trouble::file_system);
  if (!keep) cut(0);
}

GrowingFile::~GrowingFile() {
  if (descriptor_ > STDERR_FILENO) ::close(descriptor_);
}

void GrowingFile::fail(const std::string& what, int code) const {
  throw Error(
      Fault{{path_ == "-" ? "standard output" : path_, 0, 0}, "", what + ": " + std::strerror(code), "", ""},
      Trouble::file_system);
}

std::string GrowingFile::read(std::uint64_t from, std::size_t most) {
  std::string text(most, '\0');
  std::size_t done = 0;
  while (done < most) {
    const ssize_t n = pread(descriptor_, text.data() + done, most - done, static_cast<off_t>(from + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail("cannot be read", errno);
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  text.resize(done);
  return text;
}

void GrowingFile::cut(std::uint64_t size) {
  if (ftruncate(descriptor_, static_cast<off_t>(size)) != 0) fail("cannot be cut off", errno);
  if (lseek(descriptor_, 0, SEEK_END) < 0) fail("cannot be written", errno);
}

void GrowingFile::write(std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(descriptor_, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EPIPE) throw ClosedPipe{};
    if (n < 0) fail("cannot be written", errno);
    text.remove_prefix(static_cast<std::size_t>(n));
  }
}

void GrowingFile::synchronize() {
  if (regular_ && fdatasync(descriptor_) != 0) fail("cannot be written", errno);
}

std::string GrowingFile::note() const {
  constexpr std::size_t longest = 4096;  // of one block, to which most file systems limit them
  std::string text(longest, '\0');
  const ssize_t size = regular_ ? fgetxattr(descriptor_, note_name, text.data(), text.size()) : -1;
  text.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
  return text;
}

void GrowingFile::set_note(const std::string& text) {
  if (regular_ && fsetxattr(descriptor_, note_name, text.data(), text.size(), 0) != 0)
    std::ignore = fremovexattr(descriptor_, note_name);  // rather none than that of earlier bytes
}

void GrowingFile::close() {
  if (descriptor_ == STDOUT_FILENO) return;
  if (regular_ && fsync(descriptor_) != 0) fail("cannot be written", errno);
  const int closed = ::close(descriptor_);
  descriptor_ = -1;
  if (closed != 0) fail("cannot be written", errno);
}

}  // namespace qerr
