#pragma once

#include <Eigen/Core>

namespace qerr {

/// columns' diag(weight) columns.
///
/// Quick for tables, of whose columns all but two are nought in any row: rows are taken some at a time, and
/// of the columns those that are not nought in them. What is left out adds nothing; sums differ from the
/// plain product's by rounding.
Eigen::MatrixXd weighted_square(const Eigen::MatrixXd& columns, const Eigen::ArrayXd& weight);

}  // namespace qerr
