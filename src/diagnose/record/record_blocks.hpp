#pragma once

#include <vector>

#include "diagnose/record/evidence.hpp"
#include "effect/term.hpp"

namespace qerr {

/// First rows of the blocks of a record for cross-validation and block bootstrap. A block is long compared
/// with the correlation of neighbouring rows: at least 50 rows and, if the record is long enough, one
/// revolution of the encoder's shaft or the motion between two reversals. A record of 400 or more rows has 8
/// to 128 blocks.
std::vector<Eigen::Index> block_starts(const Evidence&);

/// A record, or a term of it, restricted to some rows.
Evidence rows_of(const Evidence&, const std::vector<Eigen::Index>& rows);
Term rows_of(const Term&, const std::vector<Eigen::Index>& rows);

}  // namespace qerr
