#include "diagnose/surrogates/surrogate.hpp"

#include <algorithm>
#include <cmath>

#include "core/random.hpp"
#include "core/search.hpp"

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

}  // namespace qerr
