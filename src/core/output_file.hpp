#pragma once

#include <cstdint>
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

/// An output that grows while its rows are computed, so that an interrupted run can be continued: unlike an
/// OutputFile it is written under its own name, and what is written stays there whatever ends the process.
///
/// A regular file is locked: a second process that opens it is refused. Pipes, devices and standard output
/// are written directly. The file is noted as an output of the run (run_files.hpp).
/// @throws Error (usage) if it is an input or another output of the run; (file_system) with the path and the
/// reason given by the system; ClosedPipe (output_file.hpp)
class GrowingFile {
 public:
  /// @param path    "-" is standard output
  /// @param option  of the command line that names it, for messages
  /// @param keep    what the file holds; else it is emptied
  GrowingFile(std::string path, const std::string& option, bool keep);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  const std::string& path() const { return path_; }
  /// Whether the file can be read back and cut off; pipes and devices cannot.
  bool regular() const { return regular_; }
  /// Up to `most` bytes from a position; fewer only at the end. @pre regular()
  std::string read(std::uint64_t from, std::size_t most);
  /// Cuts the file off and continues there. @pre regular()
  void cut(std::uint64_t size);

  /// Appends the text, before it returns.
  void write(std::string_view text);
  /// Waits until all that is written is on the disk.
  void synchronize();
  /// A text that the system keeps with the file, apart from its bytes (an extended attribute); "" if there is
  /// none. Not every file system has them, and not every copy: what depends on it must do without.
  std::string note() const;
  void set_note(const std::string& text);
  /// Synchronizes and closes.
  void close();

 private:
  [[noreturn]] void fail(const std::string& what, int code) const;

  std::string path_;
  int descriptor_ = -1;
  bool regular_ = false;
};

}  // namespace qerr
