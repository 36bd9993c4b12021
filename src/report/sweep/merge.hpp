#pragma once

#include <functional>
#include <string>
#include <vector>

namespace qerr {

/// Joins the files of all shards of a sweep.
/// @param write  is called with the bytes that one run would have written, in order
/// @throws Error (input) naming the files, if one is torn, given twice or of another sweep, or if one is
/// missing; (file_system) if one cannot be read
void merge_shards(const std::vector<std::string>& files,
                  const std::function<void(const std::string&)>& write);

}  // namespace qerr
