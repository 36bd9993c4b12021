#include "core/output_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <utility>

#include "core/run_files.hpp"
#include "core/text.hpp"
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
  if (slot >= 0) unfinished[slot].used = 0;
}

bool is_special(const std::string& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode);
}

/// The folder of a file, as a path to open.
std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

/// A name for a temporary file in the folder of a file. It is random, as process ids repeat from container to
/// container, and no file that a killed process has left must hinder a later one.
std::string random_name(const std::string& path) {
  std::array<unsigned char, 8> bytes{};
  if (getrandom(bytes.data(), bytes.size(), GRND_NONBLOCK) < 0) {
    const auto ticks = static_cast<std::uint64_t>(std::clock()) ^ static_cast<std::uint64_t>(getpid()) << 32;
    std::memcpy(bytes.data(), &ticks, bytes.size());
  }
  std::string name = folder_of(path) + "/.qerr.";
  for (const unsigned char byte : bytes) name += hexadecimal(byte);
  return name + ".tmp";
}

constexpr int most_names = 100;

/// The path under which the system shows an open file of this process.
std::string path_of(int descriptor) { return "/proc/self/fd/" + std::to_string(descriptor); }

/// Opens a file without a name in a folder, which disappears with the process; -1 where the file system has
/// none, or the system does not show it (/proc), so that it could not be given a name.
int open_unnamed(const std::string& folder) {
#ifdef O_TMPFILE
  const int descriptor = open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
  if (descriptor < 0) return -1;
  struct stat status {};
  if (stat(path_of(descriptor).c_str(), &status) == 0) return descriptor;
  close(descriptor);
#endif
  return -1;
}

/// Makes the name of a new file persistent. Folders that cannot be opened or synchronized, as on some file
/// systems, are left to the system.
void synchronize_folder(const std::string& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  std::ignore = fsync(descriptor);
  close(descriptor);
}

constexpr const char* note_name = "user.qerr";

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
    path_ = link_target(path_);  // is replaced, and not the link
    struct stat status {};
    const bool replaces = stat(path_.c_str(), &status) == 0;
    if (!replaces && errno != ENOENT) fail("cannot be opened for writing", errno);
    descriptor_ = open_unnamed(folder_of(path_));
    unnamed_ = descriptor_ >= 0;
    for (int i = 0; !unnamed_ && descriptor_ < 0 && i < most_names; ++i) {
      begin_temporary();
      descriptor_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor_ < 0) end_temporary();
      if (descriptor_ < 0 && errno != EEXIST) break;
    }
    // What others may not read must not become readable. Where it fails the file belongs to somebody else.
    if (descriptor_ >= 0 && replaces) std::ignore = fchmod(descriptor_, status.st_mode & 0777);
  }
  if (descriptor_ < 0) fail("cannot be opened for writing", errno);
}

OutputFile::~OutputFile() {
  if (descriptor_ > STDERR_FILENO) ::close(descriptor_);
  if (!temporary_.empty()) unlink(temporary_.c_str());
  end_temporary();
}

void OutputFile::begin_temporary() {
  temporary_ = random_name(path_);
  slot_ = remember(temporary_);
}

void OutputFile::end_temporary() {
  forget(slot_);
  slot_ = -1;
  temporary_.clear();
}

void OutputFile::fail(const std::string& what, int code) {
  throw Error({path_ == "-" ? "standard output" : path_, 0, 0}, "", what + ": " + std::strerror(code), "", "",
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
  const bool regular = unnamed_ || !temporary_.empty();
  if (regular && fsync(descriptor_) != 0) fail("cannot be written", errno);
  // A file without a name lives as long as it is open.
  const int kept = unnamed_ ? fcntl(descriptor_, F_DUPFD_CLOEXEC, STDERR_FILENO + 1) : -1;
  if (unnamed_ && kept < 0) fail("cannot be written", errno);
  const int closed = ::close(std::exchange(descriptor_, kept));
  if (closed != 0) fail("cannot be written", errno);
  if (!regular) return;
  put_in_place();
  synchronize_folder(folder_of(path_));
}

void OutputFile::put_in_place() {
  if (unnamed_) {
    const std::string shown = path_of(descriptor_);
    const auto link_as = [&](const std::string& name) {
      return linkat(AT_FDCWD, shown.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
    };
    bool linked = link_as(path_);
    const bool whole = linked;
    for (int i = 0; !linked && errno == EEXIST && i < most_names; ++i) {  // a link does not replace a file
      end_temporary();
      begin_temporary();
      linked = link_as(temporary_);
    }
    if (!linked) {
      const int code = errno;
      end_temporary();
      fail("cannot be replaced", code);
    }
    ::close(std::exchange(descriptor_, -1));
    if (whole) return;
  }
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) fail("cannot be replaced", errno);
  end_temporary();
}

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
    throw Error({path_}, option, "another process is writing this file", "",
                "wait for it, or give the output another name", Trouble::file_system);
  if (!keep) cut(0);
}

GrowingFile::~GrowingFile() {
  if (descriptor_ > STDERR_FILENO) ::close(descriptor_);
}

void GrowingFile::fail(const std::string& what, int code) const {
  throw Error({path_ == "-" ? "standard output" : path_, 0, 0}, "", what + ": " + std::strerror(code), "", "",
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
    text.remove_prefix(n);
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
