#include "input/read_text.hpp"

#include "core/run_files.hpp"
#include "core/text.hpp"
#include "input/byte_source.hpp"
#include "qerr/core/error.hpp"

namespace qerr {

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
