#pragma once

#include <string>
#include <string_view>

namespace qerr {

/// Thrown when the reading end of a pipe is closed (`| head`), which is not an error.
struct ClosedPipe {};

/// Removes the temporary files of all open outputs. Async-signal-safe.
void remove_unfinished_outputs();

/// An output: a regular file that is created completely or not at all, or a pipe, device or standard output
/// that is written directly.
///
/// A regular file is written to a temporary file in the same folder, which close() synchronizes and puts in
/// the place of the old one; without close() it is removed. It has no name until then, so that nothing is
/// left whatever ends the process; where the file system cannot do that, a random name. The constructor opens
/// it, so that a path that is not writable fails before the computation, and notes it as an output of the run
/// (run_files.hpp).
/// @throws Error (usage) if it is an input or another output of the run; Error (file_system) with the path
/// and the reason given by the system; ClosedPipe
class OutputFile {
 public:
  /// @param path    "-" is standard output
  /// @param option  of the command line that names it, for messages; may be empty
  explicit OutputFile(std::string path, const std::string& option = {});
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view text);
  void close();

 private:
  [[noreturn]] void fail(const std::string& what, int code);
  void flush();
  void put_in_place();
  /// Chooses a name for the temporary file, and forgets it.
  void begin_temporary();
  void end_temporary();

  std::string path_, temporary_, buffer_;
  int descriptor_ = -1;
  bool unnamed_ = false;  ///< the temporary file has no name
  int slot_ = -1;         ///< index in the list of unfinished outputs
};

}  // namespace qerr
