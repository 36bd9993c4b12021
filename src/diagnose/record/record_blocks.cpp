#include "diagnose/record/record_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace qerr {

namespace {

/// @param fewest  blocks, if the record is long enough
std::vector<Eigen::Index> starts_of_blocks(const Evidence& e, Eigen::Index fewest) {
  const Eigen::Index n = e.rows();
  const Eigen::Index least = std::max<Eigen::Index>(std::min<Eigen::Index>(50, n / 4), (n + 127) / 128);
  const Eigen::Index most = std::max(least, n / fewest);
  const double revolution = 2 * std::numbers::pi / std::max(std::abs(e.encoder.shaft_ratio), 1e-12);
  std::vector<Eigen::Index> starts{0};
  bool reversed = false;
  double travel = 0;
  for (Eigen::Index k = 1; k < n; ++k) {
    reversed |= e.direction[k] != e.direction[k - 1];
    travel += std::abs(e.path[k] - e.path[k - 1]);
    const Eigen::Index length = k - starts.back();
    const bool enough = reversed || travel > revolution || length >= most;
    if (length < least || !enough || n - k < least) continue;
    starts.push_back(k);
    reversed = false;
    travel = 0;
  }
  return starts;
}

}  // namespace

std::vector<Eigen::Index> block_starts(const Evidence& e) {
  constexpr std::size_t few = 12;
  constexpr Eigen::Index coarse = 8, fine = 53;  // a prime: blocks are not commensurate with any low order
  std::vector<Eigen::Index> starts = starts_of_blocks(e, coarse);
  // Alternate blocks of an eighth of a revolution would exclude half of every period of order 4 from the fit.
  return starts.size() < few ? starts_of_blocks(e, fine) : starts;
}

Evidence rows_of(const Evidence& e, const std::vector<Eigen::Index>& rows) {
  Evidence part = e;
  for (Eigen::ArrayXd* series : series_of(part))
    if (series->size() > 0) *series = Eigen::ArrayXd((*series)(rows));
  return part;
}

Term rows_of(const Term& t, const std::vector<Eigen::Index>& rows) {
  Term part = t;
  part.columns = t.columns(rows, Eigen::all);
  if (t.moved.size() > 0) part.moved = Eigen::ArrayXd(t.moved(rows));
  if (t.fixed.size() > 0) part.fixed = Eigen::ArrayXd(t.fixed(rows));
  return part;
}

}  // namespace qerr
