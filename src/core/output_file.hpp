#pragma once

#include <string>
#include <string_view>

namespace qerr {

/// Thrown when the reader of a pipe has gone (`| head`): an ordinary end, with nothing to report.
struct ClosedPipe {};

/// Removes the temporary files of all open outputs; safe to call in a signal handler.
void remove_unfinished_outputs();

/// Where results go: a file that appears whole or not at all, or a pipe, device or standard output, written
/// directly.
///
/// A regular file is written to a temporary one beside it, synced and renamed by close(); without close() the
/// temporary is removed. It is opened by the constructor, so that a path that cannot be written fails before
/// the work.
/// @throws Error (file_system) with the path and the system's reason; ClosedPipe
class OutputFile {
 public:
  explicit OutputFile(std::string path);  ///< "-": standard output
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  void close();

 private:
  [[noreturn]] void fail(const std::string& what, int code);
  void flush();

  std::string path_, temporary_, buffer_;
  int descriptor_ = -1;
  int slot_ = -1;  ///< place among the unfinished outputs
};

}  // namespace qerr
