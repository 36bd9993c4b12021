#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace qerr {

/// What ends a line of the CSV that qerr writes; no cell has one.
inline constexpr std::string_view csv_line_break = "\r\n";

/// The last column of shards that have one variant at most each: K/N. The numbers of the variants do not tell
/// then how many shards there are; qerr merge takes it off again.
inline constexpr std::string_view shard_column = ",shard";

/// The number of cells of a line that qerr has written: commas within quotation marks divide none.
std::size_t cells_of(std::string_view line);

/// What shows that a line which qerr has written was damaged since: another number of cells than the header,
/// characters that qerr does not write, or the same line as before; "" if nothing does.
std::string damage_of(std::string_view line, std::string_view before, std::size_t cells);

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

}  // namespace qerr
