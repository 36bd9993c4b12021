#include "input/byte_source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "core/run_files.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

namespace {

[[noreturn]] void unreadable(const std::string& path, const std::string& rule,
                             const std::string& remedy = {}) {
  throw Error(Fault{{path}, "", rule, "", remedy}, Trouble::file_system);
}

std::string reason(int code) { return std::generic_category().message(code); }

int open_input(const std::string& path) {
  note_input(path);
  if (path == "-") return STDIN_FILENO;
  if (path.empty()) unreadable(path, "the name of a file is empty", "is a variable of the shell not set?");
  if (path.find('\0') != std::string::npos) unreadable(path, "a file name cannot contain a NUL byte");
  struct stat status {};
  // Checked before opening: opening a device can act on it or block.
  if (::stat(path.c_str(), &status) != 0) unreadable(path, "cannot be opened: " + reason(errno));
  if (S_ISDIR(status.st_mode)) unreadable(path, "is a directory", "name a file in it");
  if (!S_ISREG(status.st_mode) && !S_ISFIFO(status.st_mode))
    unreadable(path, "must be a regular file or a pipe");
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) unreadable(path, "cannot be opened: " + reason(errno));
  return descriptor;
}

}  // namespace

ByteSource::ByteSource(const std::string& path)
    : name_(path == "-" ? "(standard input)" : path), descriptor_(open_input(path)) {
  struct stat status {};
  regular_ = fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode);
  // Standard input may begin within its file, as behind `head` in a shell's brackets.
  const off_t begin = regular_ ? lseek(descriptor_, 0, SEEK_CUR) : -1;
  if (begin >= 0 && begin < status.st_size) size_ = static_cast<std::uint64_t>(status.st_size - begin);
}

ByteSource::~ByteSource() {
  if (descriptor_ > STDIN_FILENO) ::close(descriptor_);  // standard input stays open
}

std::size_t ByteSource::read(char* buffer, std::size_t most) {
  while (true) {
    const ssize_t count = ::read(descriptor_, buffer, most);
    if (count == 0 && most > 0 && position_ < size_)
      unreadable(name_, "became shorter while it was read", "repeat this when the file is whole");
    if (count >= 0) {
      position_ += static_cast<std::uint64_t>(count);
      return static_cast<std::size_t>(count);
    }
    if (errno != EINTR) unreadable(name_, "cannot be read: " + reason(errno));
  }
}

}  // namespace qerr
