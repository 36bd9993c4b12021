#include "simulate/quantization_along_motion.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "filter/run/row_filter.hpp"
#include "simulate/unrounded_record.hpp"

namespace qerr {

namespace {

/// Errors of a quantizer at x + u, [x + u] - x - u in counts, for equally spaced u in [0, 1).
void errors_of_zeros(double x, std::size_t zeros, double* errors) {
  // The addition rounds to the nearest integer and, unlike floor, in a vector.
  constexpr double shift = 0x1.8p52;
  const double first = std::remainder(x, 1.0) + 0.5 / static_cast<double>(zeros);
  const double step = 1 / static_cast<double>(zeros);
  for (std::size_t k = 0; k < zeros; ++k) {
    const double position = first + static_cast<double>(k) * step;
    errors[k] = ((position + shift) - shift) - position;
  }
}

/// Filtered errors of one encoder at all zeros, and the sum of their squares.
class FilteredZeros {
 public:
  FilteredZeros(const Filter& filter, std::size_t zeros)
      : zeros_(zeros),
        filter_(filter, zeros, batch_size),
        errors_(zeros * batch_size),
        out_(errors_.size()) {}

  /// @param x     positions at successive samples [counts]
  /// @param from  the first that counts
  void add(const std::vector<double>& x, std::size_t from) {
    for (std::size_t i = 0; i < x.size(); ++i) errors_of_zeros(x[i], zeros_, errors_.data() + i * zeros_);
    if (!settled_) filter_.settle(errors_.data());
    settled_ = true;
    filter_(errors_.data(), zeros_, x.size(), out_.data());
    sum_ += Eigen::Map<const Eigen::VectorXd>(out_.data() + from * zeros_,
                                              static_cast<Eigen::Index>((x.size() - from) * zeros_))
                .squaredNorm();
  }

  double sum() const { return sum_ / static_cast<double>(zeros_); }

 private:
  std::size_t zeros_;
  RowFilter filter_;
  AlignedNumbers errors_, out_;
  bool settled_ = false;
  double sum_ = 0;
};

}  // namespace

std::uint64_t zeros_along_motion(std::uint64_t samples) {
  constexpr std::uint64_t evaluated = std::uint64_t{1} << 20;
  return std::clamp<std::uint64_t>(evaluated / std::max<std::uint64_t>(samples, 1) / 8 * 8, 16, 256);
}

std::optional<Eigen::VectorXd> sigma_along_motion(const OperationalModel& model,
                                                  const std::vector<Effect>& effects, const Motion& motion,
                                                  const Filter& filter, double settling) {
  if (motion.duration * filter.sample_rate > longest_record) return std::nullopt;
  const UnroundedRecord record(motion, filter.sample_rate, settling);
  const std::vector<Encoder>& encoders = model.transmission.encoders;
  std::vector<FilteredZeros> zeros;
  for (std::size_t e = 0; e < encoders.size(); ++e)
    zeros.emplace_back(filter, zeros_along_motion(record.used()));
  std::vector<double> x;
  record.read(model, effects, [&](const SensedBatch& batch, const std::vector<std::size_t>& used) {
    const auto from = static_cast<std::size_t>(std::count_if(
        used.begin(), used.end(), [&](std::size_t i) { return !record.counts(batch.first + i); }));
    for (std::size_t e = 0; e < encoders.size(); ++e) {
      x.clear();
      for (const std::size_t i : used)
        x.push_back(batch.measured[e * batch_size + i] / encoders[e].resolution);
      zeros[e].add(x, from);
    }
  });
  Eigen::VectorXd sigma(static_cast<Eigen::Index>(encoders.size()));
  for (std::size_t e = 0; e < encoders.size(); ++e)
    sigma[static_cast<Eigen::Index>(e)] = std::sqrt(zeros[e].sum() / static_cast<double>(record.counted()));
  return sigma;
}

}  // namespace qerr
