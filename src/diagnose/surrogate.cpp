#include "surrogate.hpp"

#include <algorithm>
#include <cmath>

#include "qerr/core/random.hpp"

namespace qerr {

namespace {

constexpr std::uint64_t phase_stream = 0x7068617365, noise_stream = 0x6e6f697365;

/// Adding and taking off 1.5 * 2^52 rounds to nearest, without a call and in both halves of a register.
constexpr double rounds_off = 6755399441055744.0;

constexpr Eigen::Index shortest_rest = 50;

/// Sum of four numbers of 16 bits, to mean 0 and variance 1.
double normal_like(std::uint64_t z) {
  constexpr double mean = 4 * 32767.5, sigma = 37837.22783634604;
  const std::uint64_t pairs = (z & 0x0000ffff0000ffffu) + ((z >> 16) & 0x0000ffff0000ffffu);
  return (static_cast<double>((pairs & 0xffffffffu) + (pairs >> 32)) - mean) / sigma;
}

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

}  // namespace

std::vector<Stretch> stretches(Eigen::Index rows, Eigen::Index most) {
  if (rows <= most) return {{0, rows}};
  constexpr Eigen::Index count = 16;
  std::vector<Stretch> all;
  for (Eigen::Index i = 0; i < count; ++i)
    all.push_back({i * (rows - most / count) / (count - 1), most / count});
  return all;
}

Surrogate::Surrogate(const Evidence& e, std::uint64_t seed, std::uint64_t lane, Eigen::Index lanes)
    : e_(e),
      noise_(e.noise / e.step()),
      below_(e.encoder.rounding == Rounding::down ? 0.5 : 0.0),
      path_(straightened(e)),
      rest_(Eigen::ArrayXi::Zero(e.rows())),
      phase_(lanes) {
  const double part = kept(e, path_);
  pole_ = pole_that_keeps(part);
  find_rests(part);
  for (Eigen::ArrayXd* a : {&first_, &second_, &drawn_, &level_, &x_}) *a = Eigen::ArrayXd::Zero(lanes);
  for (Eigen::Index i = 0; i < lanes; ++i) {
    const std::uint64_t number = lane + static_cast<std::uint64_t>(i);
    state_.push_back(random_bits(seed, number, noise_stream));
    phase_[i] = e.encoder.zero_known ? 0 : unit_interval(random_bits(seed, number, phase_stream)) - 0.5;
  }
}

/// Where the path goes no farther than its own noise: one position, its mean.
void Surrogate::find_rests(double part) {
  if (!e_.ordered) return;
  const double reach = 4 * noise_ * std::sqrt(part);
  for (Eigen::Index first = 0, end = 0; first < path_.size(); first = end) {
    double sum = 0;
    for (end = first; end < path_.size(); ++end) {
      if (end > first && std::abs(path_[end] - sum / static_cast<double>(end - first)) > reach) break;
      sum += path_[end];
    }
    if (end - first < shortest_rest) continue;
    path_.segment(first, end - first) = sum / static_cast<double>(end - first);
    rest_.segment(first, end - first) = static_cast<int>(end - first);
  }
}

/// One step of SplitMix64 a lane.
void Surrogate::draw_numbers() {
  for (std::size_t i = 0; i < state_.size(); ++i) {
    std::uint64_t z = (state_[i] += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    drawn_[static_cast<Eigen::Index>(i)] = normal_like(z ^ (z >> 31));
  }
}

void Surrogate::draw() {
  draw_numbers();
  first_ = pole_ * first_ + (1 - pole_) * noise_ * drawn_;
  second_ = pole_ * second_ + (1 - pole_) * first_;
}

void Surrogate::start() {
  first_.setZero();
  second_.setZero();
  resting_ = 0;
  for (double left = 1; left > 1e-2; left *= std::max(pole_, 1e-3)) draw();
}

void Surrogate::read(Eigen::Index row, Eigen::ArrayXd& residual, Eigen::ArrayXi& state) {
  draw();
  // One rest follows another when the joint has moved a little between them.
  if (rest_[row] > 0 && (resting_ == 0 || path_[row] != path_[row - 1]))
    level_ = noise_ / std::sqrt(static_cast<double>(rest_[row])) * drawn_;
  resting_ = rest_[row];
  x_ = resting_ > 0 ? level_ : second_;
  if (e_.chance.size() > 0) {
    // What the model itself leaves to chance comes before the quantizer.
    draw_numbers();
    x_ += e_.chance[row] / e_.step() * drawn_;
  }
  // The whole counts are taken off first, so that rounding keeps its digits far from zero.
  const double whole = std::floor(path_[row]);
  x_ += (path_[row] - whole - below_) + phase_;
  residual = (x_ + rounds_off) - rounds_off;
  const int whole_state = static_cast<int>(std::fmod(whole, 4.0)) + 4;
  for (Eigen::Index i = 0; i < x_.size(); ++i) state[i] = (whole_state + static_cast<int>(residual[i])) & 3;
  residual -= phase_ + (e_.reference[row] / e_.step() - whole);
}

}  // namespace qerr
