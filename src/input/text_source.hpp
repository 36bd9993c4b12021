#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "qerr/core/error.hpp"

namespace qerr {

/// The bytes of an input: a regular file, a pipe, or `-` for standard input.
class ByteSource {
 public:
  /// @throws Error (file_system) if it cannot be opened, or is a directory or a device
  explicit ByteSource(const std::string& path);
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;
  ~ByteSource();

  /// Reads at most `most` bytes. @returns their number; 0 at the end
  /// @throws Error (file_system) if the system reports an error, or a file ends before the size that it had
  std::size_t read(char* buffer, std::size_t most);

  bool regular() const { return regular_; }  ///< a file that can be read again, and no pipe
  /// Bytes of a regular file, of standard input those that are left; 0 of a pipe.
  std::uint64_t size() const { return size_; }
  /// Bytes read so far.
  std::uint64_t position() const { return position_; }

  const std::string& name() const { return name_; }

 private:
  std::string name_;
  int descriptor_ = -1;
  bool regular_ = false;
  std::uint64_t size_ = 0, position_ = 0;
};

/// The text of an input document: a regular file, a pipe, or `-` for standard input, with at most 16 MB of
/// valid UTF-8 without NUL. A leading byte-order mark is removed.
/// @throws Error (file_system) if it cannot be read, (input) if its bytes are not such text
std::string read_text(const std::string& path);

/// Checks size and encoding of a text.
/// @throws Error (input), with line and column of the first invalid byte
void check_text(const std::string& text, const std::string& file);

/// The place of a byte that follows well-formed UTF-8; a column is a code point.
/// @pre byte <= text.size()
Place place_of_byte(const std::string& text, std::size_t byte, const std::string& file);

/// How the lines of a table are laid out around its cells: as JSON objects, as `t=0.1 counts=12`, between
/// brackets or pipes, behind `17:16:42.123 -> `, or ended by carriage returns alone. `plain` makes cells of
/// them in place: what is no cell becomes a blank, so that the column of every cell stays what it is in the
/// file.
class LineLayout {
 public:
  LineLayout() = default;
  /// Recognizes the layout of a text by its first lines.
  explicit LineLayout(std::string_view head);

  bool is_plain() const { return !returns_ && labels_.empty() && !framed_ && arrow_ == '\0'; }
  /// The labels of the cells, which every line repeats: the header that the table does not have.
  const std::vector<std::string>& labels() const { return labels_; }
  /// "labels before the values", for a report; "" if it is plain.
  std::string description() const;
  char line_end() const { return returns_ ? '\r' : '\n'; }

  /// Makes a line, its end included, one of cells.
  void make_plain(char* begin, char* end) const;

 private:
  bool returns_ = false;  ///< lines end with a carriage return
  bool framed_ = false;   ///< in brackets or pipes
  char arrow_ = '\0';     ///< what takes the place of `->`
  std::vector<std::string> labels_;
};

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

}  // namespace qerr
