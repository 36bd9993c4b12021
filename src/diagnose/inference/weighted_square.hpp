#pragma once

#include <Eigen/Core>

namespace qerr {

/// columns' diag(weight) columns.
///
/// Efficient for sparse tables with two non-zero columns in each row: rows are processed in blocks, and
/// columns that are zero throughout a block are skipped. The result differs from the plain product by
/// rounding.
Eigen::MatrixXd weighted_square(const Eigen::MatrixXd& columns, const Eigen::ArrayXd& weight);

}  // namespace qerr
