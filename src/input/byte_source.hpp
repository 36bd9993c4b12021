#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

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

}  // namespace qerr
