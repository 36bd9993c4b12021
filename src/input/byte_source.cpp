#include "input/byte_source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "core/run_files.hpp"
#include "core/text.hpp"
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

namespace {

constexpr std::size_t most_bytes = 16'000'000;

}  // namespace

Place place_of_byte(const std::string& text, std::size_t byte, const std::string& file) {
  Place place{file, 1, 1};
  for (std::size_t i = 0; i < byte; ++i) {
    if (text[i] == '\n') {
      ++place.line;
      place.column = 1;
    } else if ((static_cast<unsigned char>(text[i]) & 0xC0u) != 0x80u) {
      ++place.column;
    }
  }
  return place;
}

std::string read_text(const std::string& path) {
  if (auto text = piped_text(path)) return *text;
  ByteSource source(path);
  const std::string& file = source.name();
  std::string text;
  char block[65536];
  while (const std::size_t count = source.read(block, sizeof block)) {
    text.append(block, count);
    if (text.size() > most_bytes)
      throw Error(Fault{{file, 1, 1}, "", "an input document must have at most 16 MB", "more", ""});
  }
  check_text(text, file);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  if (!source.regular()) keep_piped(path, text);
  return text;
}

void check_text(const std::string& text, const std::string& file) {
  if (text.size() > most_bytes)
    throw Error(Fault{{file, 1, 1}, "", "an input document must have at most 16 MB", "more", ""});
  const bool utf16 = text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF");
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text, i);
    if (length == 0) {
      throw Error(Fault{place_of_byte(text, i, file), "", "the text must be UTF-8",
                        "byte 0x" + hexadecimal(static_cast<unsigned char>(text[i])),
                        utf16 ? "this looks like UTF-16: save the file as UTF-8" : "save the file as UTF-8"});
    }
    if (text[i] == '\0') {
      throw Error(Fault{place_of_byte(text, i, file), "", "the text must not contain a NUL byte", "",
                        "is this a text file?"});
    }
    i += length;
  }
}

}  // namespace qerr
