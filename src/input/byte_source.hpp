#pragma once

#include <cstddef>
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
  /// @throws Error (file_system) if the system reports an error
  std::size_t read(char* buffer, std::size_t most);

  /// The name used in messages.
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  int descriptor_ = -1;
};

}  // namespace qerr
