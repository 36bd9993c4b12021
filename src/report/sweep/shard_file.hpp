#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/growing_file.hpp"

namespace qerr {

/// CSV of a sweep that grows by the lines of one variant after the other.
///
/// The last line has no line break until the file is complete: whatever ends the process, a file that ends
/// with a line break is whole, and one that does not is not.
class ShardFile {
 public:
  /// @param header  without a line break
  /// @param keep    continue what the file holds (`resume`); else it is emptied and the header written
  ShardFile(const std::string& path, const std::string& option, std::string header, bool keep);

  /// Keeps the variants that the file holds and cuts off the last one, which may be torn.
  /// @param count   of the variants that the file should hold
  /// @param cells   of variant i of them: the begin of its lines
  /// @param lines   of variant i, computed anew, to compare the first and the last one that is kept
  /// @returns the number of variants that are kept
  /// @throws Error (input) if the file is not the begin of this one
  std::uint64_t resume(std::uint64_t count, const std::function<std::string(std::uint64_t)>& cells,
                       const std::function<std::string(std::uint64_t)>& lines);

  /// Appends the lines of the next variant, each with its line break.
  void write(std::string_view lines);
  void close();

 private:
  GrowingFile file_;
  std::string header_;
};

}  // namespace qerr
