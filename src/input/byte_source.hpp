#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

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

  /// The name used in messages.
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

}  // namespace qerr
