#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/output_file.hpp"
#include "core/sha256.hpp"
#include "report/sweep/run_sweep.hpp"
#include "report/sweep/shards.hpp"

namespace qerr {

/// CSV of a sweep that grows by the lines of one variant after the other, and can be continued.
///
/// The last line has no line break until the file is complete: whatever ends the process, a file that ends
/// with a line break is whole, and one that does not is not. From time to time the file is synchronized.
///
/// What keeps rows of two sweeps apart is the record of the run (shards.hpp). A shard, which is a file
/// for `qerr merge`, has it in its last column (shards.hpp). The table of a whole sweep is for its reader:
/// its record, with a checksum of the bytes so far, is a note of the file (core/output_file.hpp). Where that
/// is lost, `resume` compares the file with the variants as they are computed anew.
class ShardFile {
 public:
  /// @param header  without a line break
  /// @param marked  each variant ends with its checksum: the file of a shard
  /// @param keep    continue what the file holds (`resume`); else it is emptied and the header written
  ShardFile(const std::string& path, const std::string& option, std::string header, const RunRecord& record,
            bool marked, bool keep);

  /// Keeps the variants that the file holds unchanged.
  /// @param judged  keep none whose requirements were not evaluated
  /// @returns those that are kept; the following ones are to be written
  /// @throws Error (input), which names what differs, if the file is of another sweep
  SweepCounts resume(bool judged);
  /// Whether what the file holds has no record, and is compared with what is written.
  bool compares() const { return compared_.has_value() && !trusted_; }
  /// Whether rows that the file held, damaged or edited, were replaced.
  bool replaces() const { return replaces_; }

  /// Appends the lines of the next variants, each with its line break.
  /// @param counts  of all variants up to these
  /// @throws Error (input) if the file holds other ones
  void write(std::string_view lines, const SweepCounts& counts);
  void close();

 private:
  SweepCounts resume_marked(bool judged);
  SweepCounts resume_noted(bool judged);
  void begin_anew();
  void refuse_other(const RunRecord& held) const;
  [[noreturn]] void refuse(const std::string& rule, const std::string& found, std::uint64_t line,
                           const std::string& remedy) const;
  void put(std::string_view text);
  /// Compares with what the file holds. @returns what of the text is left to be written
  std::string_view compared(std::string_view text);
  void store_note(const SweepCounts&);

  GrowingFile file_;
  std::string header_;
  RunRecord record_;
  bool marked_;
  bool replaces_ = false;
  bool trusted_ = true;                    ///< the file is of this sweep: what differs is replaced
  std::optional<std::uint64_t> compared_;  ///< up to where the file agrees, while it is compared
  std::uint64_t line_ = 1;                 ///< of that place
  Sha256 sum_;                             ///< of all bytes up to the end
  std::uint64_t size_ = 0;
  SweepCounts counts_;  ///< of what is written
  std::chrono::steady_clock::time_point noted_, synchronized_;
};

}  // namespace qerr
