#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "input/byte_source.hpp"
#include "input/line_layout.hpp"

namespace qerr {

/// A text file as UTF-8, whatever it is written in: UTF-8 as it stands, UTF-16 behind its byte-order mark (a
/// spreadsheet's "Unicode text"), and Windows-1252 where the bytes are no UTF-8 (its CSV in Western Europe).
class TextSource {
 public:
  /// @param recognize  also texts that are not UTF-8; else their bytes are passed on as they are
  TextSource(const std::string& path, bool recognize);

  /// Reads at most `most` bytes of UTF-8; 4 or more, as many as a character can have.
  /// @returns their number; 0 at the end
  /// @throws Error like ByteSource; (input) for a binary file of a known kind, with how to export it
  std::size_t read(char* buffer, std::size_t most);

  const ByteSource& source() const { return source_; }
  /// `UTF-16` or `Windows-1252`; "" for UTF-8. Known once something is read.
  std::string_view encoding() const;
  /// How its lines are laid out, which `read` makes plain; known once something is read.
  const LineLayout& layout() const { return layout_; }

 private:
  enum class Encoding { utf8, utf16_little, utf16_big, windows_1252 };

  void recognize_encoding();
  bool refill();
  std::size_t read_text(char* buffer, std::size_t most);
  std::size_t read_lines(char* buffer, std::size_t most);
  std::size_t decoded(std::size_t at, std::string& utf8) const;

  ByteSource source_;
  bool recognize_, begun_ = false, ended_ = false;
  Encoding encoding_ = Encoding::utf8;
  std::string bytes_;  // read, and not yet passed on from `at_` on
  std::size_t at_ = 0;
  LineLayout layout_;
  std::string text_;       // UTF-8 whose lines are not yet made plain
  std::size_t plain_ = 0;  // of it, made plain and passed on up to `passed_`
  std::size_t passed_ = 0;
  bool text_ended_ = false;
};

/// Remedy for a file that begins like a known binary format: what exports it as a text; "" for any other.
std::string binary_format(std::string_view head);

}  // namespace qerr
