#include "diagnose/record/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

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

Sampling::Sampling(const Evidence& all, std::vector<RowGroup> chosen)
    : record(&all), groups(std::move(chosen)), evidence(group_means(all, groups)) {}

Eigen::ArrayXd Sampling::averaged(const Eigen::ArrayXd& column) const {
  Eigen::ArrayXd out(static_cast<Eigen::Index>(groups.size()));
  for (std::size_t g = 0; g < groups.size(); ++g)
    out[static_cast<Eigen::Index>(g)] =
        column.segment(groups[g].first, groups[g].end - groups[g].first).mean();
  return out;
}

namespace {

/// Motion of the path during a reading up to which it counts as one at rest: its quantization error varies
/// by less than the reading's own rounding.
constexpr double resting = 0.25;  // [counts]

/// Edges that are crossed, and readings at rest; without an order of the rows, every pose.
std::vector<RowGroup> sample_groups(const Evidence& e) {
  const Eigen::Index n = e.rows();
  if (!e.ordered) return independent_rows(e, 0, n);
  std::vector<RowGroup> groups;
  const double still = std::max(resting * e.step(), 4 * e.path_noise);
  const Eigen::ArrayXd path = path_without_noise(e);
  for (Eigen::Index k = 0; k < n;) {
    if (k + 1 < n && e.measured[k] != e.measured[k + 1]) {
      const bool one_edge = std::abs(e.measured[k + 1] - e.measured[k]) < 1.5 * e.step();
      groups.push_back({k, one_edge ? k + 2 : k + 1});
      k = groups.back().end;
      continue;
    }
    Eigen::Index end = k + 1;
    double low = path[k], high = path[k];
    while (end < n && e.measured[end] == e.measured[k]) {
      low = std::min(low, path[end]), high = std::max(high, path[end]);
      ++end;
    }
    // The last row of the run belongs to the edge that ends it.
    if (end - k >= 3 && high - low < still) groups.push_back({k, end - 1});
    k = std::max(k + 1, end - (end < n ? 1 : 0));
  }
  return groups;
}

/// Number of other samples that share the noise of each one's path.
Eigen::ArrayXd neighbours(const Evidence& record, const Eigen::ArrayXd& time) {
  const double reach = 0.5 * shared_rows(record) * record.interval;
  Eigen::ArrayXd count = Eigen::ArrayXd::Zero(time.size());
  if (!(shared_rows(record) > 1)) return count;
  for (Eigen::Index i = 0, first = 0, end = 0; i < time.size(); ++i) {
    while (time[first] < time[i] - reach) ++first;
    while (end < time.size() && time[end] <= time[i] + reach) ++end;
    count[i] = static_cast<double>(end - first - 1);
  }
  return count;
}

}  // namespace

ErrorSamples error_samples(const Evidence& e, std::uint64_t seed, Eigen::Index most) {
  ErrorSamples s{Sampling(e, drawn(sample_groups(e), seed, most)), {}, {}, {}};
  const Evidence& sampled = s.sampling.evidence;
  const double step = e.step();
  s.error = sampled.measured - sampled.path + (0.5 - below_reading(e.encoder)) * step;
  s.variance.resize(sampled.rows());
  s.shared = neighbours(e, sampled.time) * e.path_noise * e.path_noise;
  for (Eigen::Index i = 0; i < sampled.rows(); ++i) {
    const RowGroup& g = s.sampling.groups[static_cast<std::size_t>(i)];
    const bool edge = e.measured[g.first] != e.measured[g.end - 1];
    const double moved = (e.path[g.end - 1] - e.path[g.first]) / step;
    const double rounding = edge ? std::min(moved * moved, 1.0) / 12 : 1.0 / 12;
    const double averaged = edge ? 2 : 1;
    s.shared[i] /= averaged;
    s.variance[i] = rounding * step * step + e.path_noise * e.path_noise / averaged;
    if (sampled.random_sigma.size() > 0) s.variance[i] += std::pow(sampled.random_sigma[i], 2) / averaged;
  }
  // An edge that is crossed at almost no speed has no rounding error, but its own one: edges are not placed
  // better than to a few percent of a count.
  s.variance = s.variance.max(std::pow(0.03 * step, 2));
  return s;
}

}  // namespace qerr
