#include "diagnose/surrogates/surrogate.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "core/random.hpp"
#include "core/search.hpp"
#include "diagnose/surrogates/residual_sums.hpp"

namespace qerr {

namespace {

constexpr std::uint64_t phase_stream = 0x7068617365, noise_stream = 0x6e6f697365;

constexpr Eigen::Index shortest_standstill = 50;  ///< rows (convention)

/// Variance of unit white noise after two low-pass filters (1 - a)/(1 - a z^-1).
double filtered_variance(double a) { return (1 - a) * (1 + a * a) / std::pow(1 + a, 3); }

/// The pole at which this variance is `variance`.
double pole_of(double variance) {
  return bisect({0, 0.999}, 40, [&](double a) { return filtered_variance(a) > variance; }).middle();
}

/// Moving average over 9 rows, applied twice.
Eigen::ArrayXd slow_part(Eigen::ArrayXd x) {
  constexpr Eigen::Index half = 4;
  for (int pass = 0; pass < 2; ++pass) {
    Eigen::ArrayXd sums(x.size() + 1);
    sums[0] = 0;
    for (Eigen::Index k = 0; k < x.size(); ++k) sums[k + 1] = sums[k] + x[k];
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const Eigen::Index width = std::min({half, k, x.size() - 1 - k});
      x[k] = (sums[k + width + 1] - sums[k - width]) / static_cast<double>(2 * width + 1);
    }
  }
  return x;
}

/// The path without the distortion by smoothing: the slow part of what smoothing removed is added again
/// (Tukey's twicing) [counts].
Eigen::ArrayXd undistorted(const Evidence& e) {
  if (!e.ordered) return e.path / e.step();
  return (e.path + slow_part(e.reference - e.path)) / e.step();
}

/// Share of the noise's variance that remains in the path.
double remaining_variance(const Evidence& e, const Eigen::ArrayXd& path) {
  if (e.noise <= 0 || e.rows() < 2) return 1;
  const double removed = (e.reference / e.step() - path).square().mean() * std::pow(e.step() / e.noise, 2);
  return std::clamp(1 - removed, 0.03, 1.0);
}

/// Replaces the path by its mean at standstill, where it stays within `noise` of its mean.
/// @returns the number of rows of the standstill that contains a row, 0 in motion
Eigen::ArrayXi average_standstills(Eigen::ArrayXd& path, double noise) {
  Eigen::ArrayXi length = Eigen::ArrayXi::Zero(path.size());
  for (Eigen::Index first = 0, end = 0; first < path.size(); first = end) {
    double sum = 0;
    for (end = first; end < path.size(); ++end) {
      if (end > first && std::abs(path[end] - sum / static_cast<double>(end - first)) > noise) break;
      sum += path[end];
    }
    if (end - first < shortest_standstill) continue;
    path.segment(first, end - first) = sum / static_cast<double>(end - first);
    length.segment(first, end - first) = static_cast<int>(end - first);
  }
  return length;
}

}  // namespace

std::vector<RowRange> sampled_ranges(Eigen::Index rows, Eigen::Index most) {
  if (rows <= most) return {{0, rows}};
  constexpr Eigen::Index count = 16;
  std::vector<RowRange> all;
  for (Eigen::Index i = 0; i < count; ++i)
    all.push_back({i * (rows - most / count) / (count - 1), most / count});
  return all;
}

SurrogatePlan surrogate_plan(const Evidence& e, const std::vector<RowRange>& ranges) {
  using Standstill = SurrogateRow::Standstill;
  Eigen::ArrayXd path = undistorted(e);
  const double variance = remaining_variance(e, path), noise = e.noise / e.step();
  const double below = 0.5 - below_reading(e.encoder);
  const Eigen::ArrayXi standstill = e.ordered ? average_standstills(path, 4 * noise * std::sqrt(variance))
                                              : Eigen::ArrayXi::Zero(path.size());
  SurrogatePlan plan{{}, {pole_of(variance), noise, e.random_sigma.size() > 0}, e.encoder.zero_known};
  plan.rows.reserve(ranges.size() * static_cast<std::size_t>(ranges.front().rows));
  for (const RowRange& s : ranges)
    for (Eigen::Index k = s.first; k < s.first + s.rows; ++k) {
      // Whole counts are subtracted first, so that large positions lose no digits.
      const double count = std::floor(path[k]);
      SurrogateRow row{path[k] - count - below,
                       e.reference[k] / e.step() - count,
                       0,
                       0,
                       Standstill::none,
                       static_cast<std::int32_t>(count - 4 * std::floor(0.25 * count))};
      if (plan.noise.random_effects) row.random_sigma = e.random_sigma[k] / e.step();
      if (standstill[k] > 0) {
        // Two standstills are consecutive if the joint moved a little between them.
        const bool begins = k == s.first || standstill[k - 1] == 0 || path[k] != path[k - 1];
        row.standstill = begins ? Standstill::begins : Standstill::continues;
        row.standstill_sigma = noise / std::sqrt(static_cast<double>(standstill[k]));
      }
      plan.rows.push_back(row);
    }
  return plan;
}

Surrogates::Surrogates(const SurrogatePlan& plan, std::uint64_t seed, std::uint64_t first, std::size_t width,
                       InstructionSet set)
    : plan_(plan),
      kernels_(select_kernels<ResidualKernels>(set)),
      width_(width),
      generator_(width),
      phase_(width),
      first_(width),
      second_(width),
      standstill_(width) {
  for (std::size_t i = 0; i < width; ++i) {
    generator_[i] = random_bits(seed, first + i, noise_stream);
    phase_[i] = plan.zero_known ? 0 : unit_interval(random_bits(seed, first + i, phase_stream)) - 0.5;
  }
}

SurrogateLanes Surrogates::lanes() {
  return {generator_.data(), phase_.data(), first_.data(), second_.data(), standstill_.data()};
}

void Surrogates::start() {
  for (const AlignedNumbers* a : {&first_, &second_}) std::fill_n(a->data(), width_, 0.0);
  // The noise starts from zero: until its transient has decayed to 1 %.
  std::size_t draws = 0;
  for (double transient = 1; transient > 1e-2; transient *= std::max(plan_.noise.pole, 1e-3)) ++draws;
  kernels_.draw(plan_.noise, draws, width_, lanes());
}

void Surrogates::read(std::size_t row, std::size_t rows, double* residual, double* state) {
  kernels_.read(plan_.noise, plan_.rows.data() + row, rows, width_, lanes(), residual, state);
}

namespace {

/// Lanes per vector of the widest instruction set, so that the batches are the same for all sets, and vectors
/// per batch.
constexpr std::size_t lanes_per_vector = 8, vectors_per_batch = 4;

/// Statistics of `width` lanes from `first` on; lane 0 is the record itself.
std::vector<ResidualStatistic> run(const ResidualPlan& plan, std::uint64_t seed, std::size_t first,
                                   std::size_t width, InstructionSet set) {
  constexpr std::size_t most_rows = ResidualSums::most_rows;
  Surrogates surrogates(plan.surrogates, seed, first, width, set);
  ResidualSums sums(plan, width, set);
  const AlignedNumbers residual(most_rows * width), state(most_rows * width);
  std::size_t row = 0;
  for (const RowRange& range : plan.ranges) {
    surrogates.start();
    sums.start();
    for (const std::size_t end = row + static_cast<std::size_t>(range.rows); row < end;) {
      const std::size_t rows = std::min(most_rows, end - row);
      surrogates.read(row, rows, residual.data(), state.data());
      for (std::size_t k = 0; first == 0 && k < rows; ++k) {
        residual[k * width] = plan.residual[static_cast<Eigen::Index>(row + k)];
        state[k * width] = plan.state[static_cast<Eigen::Index>(row + k)];
      }
      sums.add(residual.data(), state.data(), rows);
      row += rows;
    }
  }
  return sums.statistics();
}

}  // namespace

std::vector<ResidualStatistic> residual_statistics(const Evidence& e, const std::vector<Filter>& filters,
                                                   Eigen::Index surrogates, std::uint64_t seed,
                                                   unsigned threads, InstructionSet set) {
  const ResidualPlan plan = residual_plan(e, filters, set);
  const Eigen::Index all = surrogates + 1;
  const std::size_t vectors = (static_cast<std::size_t>(all) + lanes_per_vector - 1) / lanes_per_vector;
  std::vector<std::vector<ResidualStatistic>> batches((vectors + vectors_per_batch - 1) / vectors_per_batch);
  parallel_for(batches.size(), threads, [&](std::size_t i) {
    const std::size_t first = i * vectors / batches.size(), end = (i + 1) * vectors / batches.size();
    batches[i] = run(plan, seed, first * lanes_per_vector, (end - first) * lanes_per_vector, set);
  });
  std::vector<ResidualStatistic> joined = batches.front();
  for (std::size_t s = 0; s < joined.size(); ++s) {
    Eigen::ArrayXd values(all);
    Eigen::Index next = 0;
    for (const auto& batch : batches) {
      const Eigen::Index lanes = std::min(all - next, batch[s].values.size());
      values.segment(next, lanes) = batch[s].values.head(lanes);
      next += lanes;
    }
    joined[s].values = std::move(values);
  }
  return joined;
}

}  // namespace qerr
