#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace qerr {

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
