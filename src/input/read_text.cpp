#include "qerr/input/read_text.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "qerr/core/error.hpp"
#include "qerr/core/text.hpp"

namespace qerr {

namespace {

constexpr std::size_t most_bytes = 16'000'000;

[[noreturn]] void unreadable(const std::string& path, const std::string& rule,
                             const std::string& remedy = {}) {
  throw Error(Fault{{path}, "", rule, "", remedy}, Trouble::file_system);
}

std::string reason(int code) { return std::generic_category().message(code); }

/// A file descriptor that closes itself; standard input is left open.
struct Descriptor {
  int number = -1;
  explicit Descriptor(int n) : number(n) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number > STDIN_FILENO) ::close(number);
  }
};

int open_input(const std::string& path) {
  if (path == "-") return STDIN_FILENO;
  if (path.find('\0') != std::string::npos) unreadable(path, "a file name cannot hold a NUL byte");
  struct stat status {};
  // Asked before opening: opening a device can already do something, or wait for ever.
  if (::stat(path.c_str(), &status) != 0) unreadable(path, "cannot be opened: " + reason(errno));
  if (S_ISDIR(status.st_mode)) unreadable(path, "is a directory", "name a file in it");
  if (!S_ISREG(status.st_mode) && !S_ISFIFO(status.st_mode))
    unreadable(path, "is neither a regular file nor a pipe");
  const int number = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (number < 0) unreadable(path, "cannot be opened: " + reason(errno));
  return number;
}

std::string hex(unsigned char byte) {
  char buffer[8];
  std::snprintf(buffer, sizeof buffer, "0x%02X", static_cast<unsigned>(byte));
  return buffer;
}

/// The place of a byte; every byte before it belongs to well-formed UTF-8.
Place place_of(const std::string& text, std::size_t at, const std::string& file) {
  Place place{file, 1, 1};
  for (std::size_t i = 0; i < at; ++i) {
    if (text[i] == '\n') {
      ++place.line;
      place.column = 1;
    } else if ((static_cast<unsigned char>(text[i]) & 0xC0u) != 0x80u) {
      ++place.column;
    }
  }
  return place;
}

}  // namespace

std::string read_text(const std::string& path) {
  const std::string file = path == "-" ? "(standard input)" : path;
  const Descriptor input(open_input(path));
  std::string text;
  char block[65536];
  while (true) {
    const ssize_t count = ::read(input.number, block, sizeof block);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) unreadable(file, "cannot be read: " + reason(errno));
    if (count == 0) break;
    text.append(block, static_cast<std::size_t>(count));
    if (text.size() > most_bytes)
      throw Error(Fault{{file, 1, 1}, "", "an input document has at most 16 MB", "more", ""});
  }
  check_text(text, file);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  return text;
}

void check_text(const std::string& text, const std::string& file) {
  if (text.size() > most_bytes)
    throw Error(Fault{{file, 1, 1}, "", "an input document has at most 16 MB", "more", ""});
  const bool utf16 = text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF");
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text, i);
    if (length == 0) {
      throw Error(Fault{place_of(text, i, file), "", "the text must be UTF-8",
                        "byte " + hex(static_cast<unsigned char>(text[i])),
                        utf16 ? "this looks like UTF-16: save the file as UTF-8" : "save the file as UTF-8"});
    }
    if (text[i] == '\0') {
      throw Error(Fault{place_of(text, i, file), "", "the text must not hold a NUL byte", "",
                        "is this a text file?"});
    }
    i += length;
  }
}

}  // namespace qerr
