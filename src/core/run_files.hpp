#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace qerr {

/// The files of one run of a program: no output may be an input, and no two outputs may be one file.
///
/// One file is one device and inode, whatever its names; of an output that does not exist yet, one folder and
/// name. Only regular files are compared: a device or a pipe may be read and written. While no RunFiles
/// exists nothing is noted, so that a program that links qerr is free to read what it has written.
class RunFiles {
 public:
  RunFiles();
  ~RunFiles();
  RunFiles(const RunFiles&) = delete;
  RunFiles& operator=(const RunFiles&) = delete;
};

/// Permits the outputs of the run to replace what a person may have edited (--force): see note_output.
void permit_replacing_specs();

/// Notes that a file is as the run has written it, in an extended attribute where the file system has them.
void note_as_written(const std::string& path);

/// What a path stands for when symbolic links are followed, also to a file that does not exist yet. Of links
/// in a circle one of them.
std::string link_target(const std::string& path);

/// An input of the run; "-" is standard input. Names that do not exist are ignored.
/// @throws Error (usage) if it is an output of the run
void note_input(const std::string& path);

/// A file that the run has read.
struct RunInput {
  std::string path, role;  ///< role: what it is, such as `URDF`; `file` if nothing has said so
};

/// Says what an input is that has been noted.
void name_input(const std::string& path, const std::string& role);

/// The inputs noted so far, but for standard input; those of pipes, too.
std::vector<RunInput> run_inputs();

/// An output of the run, before it is opened; "-" is standard output, which only one output may have. What a
/// person may have edited is not replaced unless that is permitted, or an output of --write-... replaces it
/// and it still is as a run has written it (note_as_written): a spec, a URDF, a catalogue; by --write-spec
/// and
/// --write-model any file that is not empty.
/// @param option  of the command line that names it, for the message; may be empty
/// @throws Error (usage) if it is an input or another output of the run, or such a file
void note_output(const std::string& path, const std::string& option = {});

/// The text that a pipe gave, kept by `keep_piped` for the rest of the run: a pipe gives it once, and a spec
/// is read several times where variants of it are. Empty if there is none.
std::optional<std::string> piped_text(const std::string& path);
void keep_piped(const std::string& path, const std::string& text);

/// SHA-256 (FIPS 180-4) of bytes that come piece by piece.
class Sha256 {
 public:
  void add(std::string_view bytes);
  /// The hash of all bytes so far, as 64 hexadecimal digits.
  std::string digest() const;

 private:
  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::string rest_;  ///< less than a block of 64 bytes
  std::uint64_t size_ = 0;
};

/// SHA-256 of the bytes, as 64 hexadecimal digits: the fingerprint of a spec in its report.
std::string sha256(std::string_view bytes);

}  // namespace qerr
