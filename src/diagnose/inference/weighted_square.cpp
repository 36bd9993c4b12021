#include "diagnose/inference/weighted_square.hpp"

#include <algorithm>
#include <vector>

namespace qerr {

Eigen::MatrixXd weighted_square(const Eigen::MatrixXd& columns, const Eigen::ArrayXd& weight) {
  constexpr Eigen::Index few_columns = 8, rows_at_once = 64;
  if (columns.cols() <= few_columns) return columns.transpose() * weight.matrix().asDiagonal() * columns;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
  std::vector<Eigen::Index> present;
  Eigen::MatrixXd part, weighted;
  for (Eigen::Index first = 0; first < columns.rows(); first += rows_at_once) {
    const Eigen::Index rows = std::min(rows_at_once, columns.rows() - first);
    present.clear();
    for (Eigen::Index c = 0; c < columns.cols(); ++c)
      if ((columns.col(c).segment(first, rows).array() != 0).any()) present.push_back(c);
    part = columns(Eigen::seqN(first, rows), present);
    weighted = weight.segment(first, rows).matrix().asDiagonal() * part;
    sum(present, present) += part.transpose() * weighted;
  }
  return sum;
}

}  // namespace qerr
