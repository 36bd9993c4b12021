#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/output_file.hpp"
#include "core/run_files.hpp"
#include "report/sweep/run_sweep.hpp"

namespace qerr {

/// What the rows of a sweep depend on: the version of qerr, the spec, the files that it names, the options,
/// and the number of variants, each with its value or a fingerprint (16 digits of SHA-256).
///
/// Rows of one record may stand in one file; `difference` names what keeps two records apart.
class RunRecord {
 public:
  RunRecord() = default;
  /// @param options  names and values of those on which the rows depend
  /// @throws Error (file_system) for a file of a step that cannot be read
  RunRecord(const SpecVariants&, const SweepGrid&,
            const std::vector<std::pair<std::string, std::string>>& options);
  /// Reads `text()` back.
  explicit RunRecord(std::string_view text);

  /// One line without commas and quotation marks: `NAME=VALUE; NAME=VALUE`, sorted.
  std::string text() const;
  /// The names of the entries in which the records differ, for messages; "" if they agree.
  std::string difference(const RunRecord& other) const;
  /// The value of an entry; "" if there is none.
  std::string value(std::string_view name) const;

 private:
  std::vector<std::pair<std::string, std::string>> entries_;  // sorted
};

/// What ends a line of the CSV that qerr writes; no cell has one.
inline constexpr std::string_view csv_line_break = "\r\n";

/// The lines of a file that qerr has written, one after the other; a file is never held whole.
class CsvLines {
 public:
  /// Up to `most` bytes from a position; none only at the end.
  using Read = std::function<std::string(std::uint64_t from, std::size_t most)>;

  explicit CsvLines(Read read) : read_(std::move(read)) {}

  /// @returns false at the end
  bool next();
  std::string_view line() const { return line_; }   ///< without its line break; valid until `next`
  bool ended() const { return ended_; }             ///< it has a line break
  std::uint64_t begin() const { return begin_; }    ///< its position in the file
  std::uint64_t number() const { return number_; }  ///< from 1

 private:
  Read read_;
  std::string buffer_;  // of the file from start_ on
  std::uint64_t start_ = 0;
  std::size_t at_ = 0;  // of the next line
  std::string_view line_;
  std::uint64_t begin_ = 0, number_ = 0;
  bool ended_ = false;
};

/// The first line of a shard. Its last cell says which shard it is, and of which sweep:
/// `shard 2/5; NAME=VALUE; ...`, where the record follows the number.
struct ShardHeader {
  std::string columns;  ///< without that cell
  std::string mark;     ///< that cell
  Shard shard;
  RunRecord record;
};
std::string shard_mark(const Shard&, const RunRecord&);

/// The lines of a variant as a shard has them: with one more cell, which is empty but in the last line. There
/// it is the verdict (run_sweep.hpp) and a checksum of it, the lines and the mark of the shard.
std::string marked_lines(const std::string& lines, char verdict, const std::string& mark);

/// The variants of a shard, one after the other.
class ShardLines {
 public:
  explicit ShardLines(CsvLines::Read read) : lines_(std::move(read)) {}

  /// Reads the first line; to be called once, first. @returns empty if it is not that of a shard
  const std::optional<ShardHeader>& read_header();
  /// Whether the first line has its line break, later the last one that was read.
  bool ended() const { return lines_.ended(); }

  /// Reads the next variant. @returns false at the end
  bool next();
  /// Whether it is as it was written. @pre for all functions below
  bool whole() const { return whole_; }
  std::uint64_t variant() const { return variant_; }
  char verdict() const { return verdict_; }
  const std::string& text() const { return text_; }         ///< its lines, without the last cells
  std::uint64_t end() const { return end_; }                ///< position of the line break behind it
  std::uint64_t number() const { return lines_.number(); }  ///< of its last line

 private:
  CsvLines lines_;
  std::optional<ShardHeader> header_;
  std::string text_;
  std::uint64_t variant_ = 0, end_ = 0;
  char verdict_ = 0;
  bool whole_ = false;
};

/// Joins the files of all shards of a sweep, each of which is read once: it may be a pipe.
/// @param expected  the record of the sweep of which they must be; null: they are compared with each other
/// @param write     is called with the bytes that one run would have written, in order
/// @returns the counts of all variants
/// @throws Error (input) naming the files, if one is torn, changed, given twice or of another sweep, or if
/// one is missing; (file_system) if one cannot be read
SweepCounts merge_shards(const std::vector<std::string>& files, const RunRecord* expected,
                         const std::function<void(const std::string&)>& write);

/// CSV of a sweep that grows by the lines of one variant after the other, and can be continued.
///
/// The last line has no line break until the file is complete: whatever ends the process, a file that ends
/// with a line break is whole, and one that does not is not. From time to time the file is synchronized.
///
/// What keeps rows of two sweeps apart is the record of the run (shards.hpp). A shard, which is a file
/// for `qerr merge`, has it in its last column (shards.hpp). The table of a whole sweep is for its reader:
/// its record, with a checksum of the bytes so far, is a note of the file (core/output_file.hpp). Where that
/// is lost, all variants are computed anew.
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
  /// Whether nothing said of which sweep the rows were that the file held.
  bool unknown() const { return unknown_; }
  /// Whether rows that the file held, damaged or edited, were replaced.
  bool replaces() const { return replaces_; }

  /// Appends the lines of the next variants, each with its line break.
  /// @param counts  of all variants up to these
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
  void store_note(const SweepCounts&);

  GrowingFile file_;
  std::string header_;
  RunRecord record_;
  bool marked_;
  bool replaces_ = false;
  bool unknown_ = false;
  Sha256 sum_;  ///< of all bytes up to the end
  std::uint64_t size_ = 0;
  SweepCounts counts_;  ///< of what is written
  std::chrono::steady_clock::time_point noted_, synchronized_;
};

}  // namespace qerr
