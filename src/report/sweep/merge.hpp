#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace qerr {

/// What the files of a sweep must hold, where its spec is at hand.
struct ExpectedSweep {
  std::string header;
  std::uint64_t count = 0;                          ///< of its variants
  std::function<std::string(std::uint64_t)> cells;  ///< the begin of each line of a variant
  std::function<std::string(std::uint64_t)> lines;  ///< of a variant, computed anew
};

/// Joins the files of all shards of a sweep.
/// @param expected  compares with the spec: the values of all variants, and the figures of the first variant
/// of each file; null: the files are compared with each other only
/// @param write  is called with the bytes that one run would have written, in order
/// @throws Error (input) naming the files, if one is torn, given twice or of another sweep, or if one is
/// missing; (file_system) if one cannot be read
void merge_shards(const std::vector<std::string>& files, const ExpectedSweep* expected,
                  const std::function<void(const std::string&)>& write);

}  // namespace qerr
