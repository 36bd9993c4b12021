#pragma once

#include <vector>

#include "diagnose/terms/term.hpp"

namespace qerr {

/// First rows of stretches of a record that are long against what connects neighbouring readings: at least 50
/// of them, and as far as the record has that many a revolution of the encoder's shaft or the way from one
/// reversal to the next. There are 8 to 128 in a record of 400 rows and more; none crosses another's border,
/// so that what is true of one is no echo of the next.
std::vector<Eigen::Index> block_starts(const Evidence&);

/// Some rows of a record, and a term of it in these rows.
Evidence rows_of(const Evidence&, const std::vector<Eigen::Index>& rows);
Term rows_of(const Term&, const std::vector<Eigen::Index>& rows);

}  // namespace qerr
