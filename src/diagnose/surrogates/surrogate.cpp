#include "diagnose/surrogates/surrogate.hpp"

#include <algorithm>
#include <cmath>

#include "core/random.hpp"

namespace qerr {

namespace {

constexpr std::uint64_t phase_stream = 0x7068617365, noise_stream = 0x6e6f697365;

constexpr Eigen::Index shortest_rest = 50;

/// Variance of white noise behind two low-passes (1 - a)/(1 - a z^-1).
double variance_behind(double a) { return (1 - a) * (1 + a * a) / std::pow(1 + a, 3); }

/// The pole at which that is `part`.
double pole_that_keeps(double part) {
  double low = 0, high = 0.999;
  for (int i = 0; i < 40; ++i) (variance_behind(0.5 * (low + high)) > part ? low : high) = 0.5 * (low + high);
  return 0.5 * (low + high);
}

/// Means over 9 rows of means over 9 rows.
Eigen::ArrayXd slow_part(Eigen::ArrayXd x) {
  constexpr Eigen::Index half = 4;
  for (int pass = 0; pass < 2; ++pass) {
    Eigen::ArrayXd sums(x.size() + 1);
    sums[0] = 0;
    for (Eigen::Index k = 0; k < x.size(); ++k) sums[k + 1] = sums[k] + x[k];
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const Eigen::Index reach = std::min({half, k, x.size() - 1 - k});
      x[k] = (sums[k + reach + 1] - sums[k - reach]) / static_cast<double>(2 * reach + 1);
    }
  }
  return x;
}

/// The path with what smoothing bent put back: the slow part of what it took out (Tukey's twicing) [counts].
Eigen::ArrayXd straightened(const Evidence& e) {
  if (!e.ordered) return e.path / e.step();
  return (e.path + slow_part(e.reference - e.path)) / e.step();
}

/// Part of the noise' variance that is still in the path.
double kept(const Evidence& e, const Eigen::ArrayXd& path) {
  if (e.noise <= 0 || e.rows() < 2) return 1;
  const double taken = (e.reference / e.step() - path).square().mean() * std::pow(e.step() / e.noise, 2);
  return std::clamp(1 - taken, 0.03, 1.0);
}

/// Where the path goes no farther than its own noise: one position, its mean.
/// @return  readings of the rest that a row is in, 0 in motion
Eigen::ArrayXi take_rests(Eigen::ArrayXd& path, double reach) {
  Eigen::ArrayXi rest = Eigen::ArrayXi::Zero(path.size());
  for (Eigen::Index first = 0, end = 0; first < path.size(); first = end) {
    double sum = 0;
    for (end = first; end < path.size(); ++end) {
      if (end > first && std::abs(path[end] - sum / static_cast<double>(end - first)) > reach) break;
      sum += path[end];
    }
    if (end - first < shortest_rest) continue;
    path.segment(first, end - first) = sum / static_cast<double>(end - first);
    rest.segment(first, end - first) = static_cast<int>(end - first);
  }
  return rest;
}

}  // namespace

std::vector<Stretch> stretches(Eigen::Index rows, Eigen::Index most) {
  if (rows <= most) return {{0, rows}};
  constexpr Eigen::Index count = 16;
  std::vector<Stretch> all;
  for (Eigen::Index i = 0; i < count; ++i)
    all.push_back({i * (rows - most / count) / (count - 1), most / count});
  return all;
}

SurrogatePlan surrogate_plan(const Evidence& e, const std::vector<Stretch>& parts) {
  using Rest = SurrogateRow::Rest;
  Eigen::ArrayXd path = straightened(e);
  const double part = kept(e, path), noise = e.noise / e.step();
  const double below = e.encoder.rounding == Rounding::down ? 0.5 : 0.0;
  const Eigen::ArrayXi rest =
      e.ordered ? take_rests(path, 4 * noise * std::sqrt(part)) : Eigen::ArrayXi::Zero(path.size());
  SurrogatePlan plan{{}, {pole_that_keeps(part), noise, e.random_sigma.size() > 0}, e.encoder.zero_known};
  plan.rows.reserve(parts.size() * static_cast<std::size_t>(parts.front().rows));
  for (const Stretch& s : parts)
    for (Eigen::Index k = s.first; k < s.first + s.rows; ++k) {
      // The whole counts are taken off first, so that rounding keeps its digits far from zero.
      const double whole = std::floor(path[k]);
      SurrogateRow row{path[k] - whole - below,
                       e.reference[k] / e.step() - whole,
                       0,
                       0,
                       Rest::none,
                       static_cast<std::int32_t>(whole - 4 * std::floor(0.25 * whole))};
      if (plan.noise.chance) row.chance = e.random_sigma[k] / e.step();
      if (rest[k] > 0) {
        // One rest follows another when the joint has moved a little between them.
        const bool begins = k == s.first || rest[k - 1] == 0 || path[k] != path[k - 1];
        row.rest = begins ? Rest::begins : Rest::goes_on;
        row.level = noise / std::sqrt(static_cast<double>(rest[k]));
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
      level_(width) {
  for (std::size_t i = 0; i < width; ++i) {
    generator_[i] = random_bits(seed, first + i, noise_stream);
    phase_[i] = plan.zero_known ? 0 : unit_interval(random_bits(seed, first + i, phase_stream)) - 0.5;
  }
}

SurrogateLanes Surrogates::lanes() {
  return {generator_.data(), phase_.data(), first_.data(), second_.data(), level_.data()};
}

void Surrogates::start() {
  for (const AlignedNumbers* a : {&first_, &second_}) std::fill_n(a->data(), width_, 0.0);
  // Until the noise has forgotten where it began.
  std::size_t draws = 0;
  for (double left = 1; left > 1e-2; left *= std::max(plan_.noise.pole, 1e-3)) ++draws;
  kernels_.draw(plan_.noise, draws, width_, lanes());
}

void Surrogates::read(std::size_t row, std::size_t rows, double* residual, double* state) {
  kernels_.read(plan_.noise, plan_.rows.data() + row, rows, width_, lanes(), residual, state);
}

}  // namespace qerr
