#pragma once

#include <functional>
#include <string>
#include <vector>

#include "report/sweep/run_record.hpp"
#include "report/sweep/run_sweep.hpp"

namespace qerr {

/// Joins the files of all shards of a sweep, each of which is read once: it may be a pipe.
/// @param expected  the record of the sweep of which they must be; null: they are compared with each other
/// @param write     is called with the bytes that one run would have written, in order
/// @returns the counts of all variants
/// @throws Error (input) naming the files, if one is torn, changed, given twice or of another sweep, or if
/// one is missing; (file_system) if one cannot be read
SweepCounts merge_shards(const std::vector<std::string>& files, const RunRecord* expected,
                         const std::function<void(const std::string&)>& write);

}  // namespace qerr
