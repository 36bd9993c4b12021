#include "run.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "channel_filter.hpp"
#include "path_errors.hpp"
#include "qerr/core/random.hpp"

namespace qerr {

namespace {

constexpr std::uint64_t displacement_stream = 0x7068617365;

/// Part of a count by which each encoder's path is displaced: uniform for every run, and spread evenly over
/// the runs, so that their mean converges faster than that of independent ones.
Eigen::VectorXd displacement(const Job& job, std::uint64_t run) {
  const Eigen::VectorXd steps = resolutions(job.model.transmission);
  Eigen::VectorXd d = Eigen::VectorXd::Zero(steps.size());
  if (!job.options.random_phase) return d;
  // x^(n+1) = x + 1: the powers of 1/x make the most even additive sequence in n dimensions (Roberts 2018).
  double x = 1.5;
  for (int i = 0; i < 60; ++i) x = std::pow(1 + x, 1.0 / static_cast<double>(d.size() + 1));
  double step = 1;
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    step /= x;
    const double start =
        unit_interval(random_bits(job.options.seed, static_cast<std::uint64_t>(i), displacement_stream));
    const double phase = start + static_cast<double>(run) * step;
    d[i] = steps[i] * (phase - std::floor(phase) - 0.5);
  }
  return d;
}

class Run {
 public:
  Run(const Job& job, std::uint64_t index)
      : job_(job),
        channels_(job.model),
        visited_(index == 0 && job.options.visit),
        sensing_(job.model, job.motion, job.effects,
                 {displacement(job, index), random_bits(job.options.seed, index, 0), visited_},
                 job.options.instructions),
        errors_(job.model, sensing_.built(), job.mean, job.options.instructions),
        kernels_(simulation_kernels(job.options.instructions)),
        room_(4 * errors_.width()),
        result_{{RunStatistics(channels_.count(), channels_.coordinates, job.blocks)},
                AlongPath(channels_.coordinates, channels_.encoders)} {
    for (const Filter& filter : job.filters) {
      filters_.emplace_back(filter, errors_.width(), job.options.instructions);
      result_.outputs.push_back(result_.outputs.front());
    }
  }

  RunResult operator()(const std::function<void()>& tick) {
    for (std::uint64_t first = 0; first < job_.samples; first += batch_size) {
      const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(batch_size, job_.samples - first));
      const SensedBatch& sensed = sensing_.sense(first, count);
      for (std::size_t i = 0; visited_ && i < count; ++i) job_.options.visit(sensing_.reading(i));
      errors_(sensed, !in_one_part(first, count));
      // The first error stands for all before it: a constant one is no step.
      if (first == 0)
        for (ChannelFilter& filter : filters_) filter.settle(errors_.rows());
      expect(first, count);
      const std::uint64_t settling = std::clamp(job_.settling, first, first + count) - first;
      filter(first, 0, settling, {});
      in_parts(first, count, job_.blocks, [&](std::size_t from, std::size_t to, std::size_t block) {
        const std::size_t width = errors_.width();
        result_.outputs[0].add(errors_.rows() + from * width, width, to - from, width, block, kernels_,
                               room_.data());
        filter(first, from, to, block);
      });
      if (first % tick_samples == 0) tick();
    }
    result_.path.bound_by(errors_.rigorous(), errors_.deviation());
    return std::move(result_);
  }

 private:
  /// Calls part(from, to, number) for the parts of the record, of `parts` equal ones behind the settling,
  /// that samples first .. first + count - 1 lie in; from and to count from `first`.
  template <class Part>
  void in_parts(std::uint64_t first, std::size_t count, std::uint64_t parts, Part part) const {
    const auto number = [&](std::size_t i) {
      const double progress = (static_cast<double>(first + i) - static_cast<double>(job_.settling)) /
                              static_cast<double>(job_.samples - job_.settling);
      return static_cast<std::size_t>(progress * static_cast<double>(parts));
    };
    std::size_t from = job_.settling > first ? std::min<std::size_t>(job_.settling - first, count) : 0;
    while (from < count) {
      const std::size_t here = number(from);
      std::size_t to = count;
      if (number(count - 1) != here)
        for (to = from + 1; number(to) == here;) ++to;
      part(from, to, here);
      from = to;
    }
  }

  /// Samples first + from .. first + to - 1 through all filters, and what comes out into a block; of nothing,
  /// while they settle.
  void filter(std::uint64_t first, std::size_t from, std::size_t to, std::optional<std::size_t> block) {
    const std::size_t width = errors_.width();
    for (std::size_t f = 0; f < filters_.size(); ++f) {
      const std::uint64_t every = job_.every[f], passed = (first + from) % every;
      const std::uint64_t start = from + (passed == 0 ? 0 : every - passed);
      if (start >= to) continue;
      const auto rows = static_cast<std::size_t>((to - start - 1) / every + 1);
      const double* const out = filters_[f](errors_.rows() + start * width, every * width, rows);
      if (block) result_.outputs[f + 1].add(out, width, rows, width, *block, kernels_, room_.data());
    }
  }

  /// Whether all samples of a full batch count, and in one and the same part of everything.
  bool in_one_part(std::uint64_t first, std::size_t count) const {
    if (count < batch_size || first < job_.settling) return false;
    std::size_t parts = 0;
    for (const std::uint64_t number : {std::uint64_t{AlongPath::stretches}, job_.blocks})
      in_parts(first, count, number, [&](std::size_t, std::size_t, std::size_t) { ++parts; });
    return parts == 2 && std::all_of(job_.every.begin(), job_.every.end(), [](auto n) { return n == 1; });
  }

  /// What the Jacobian says of these samples, to the path and to the statistics.
  void expect(std::uint64_t first, std::size_t count) {
    in_parts(first, count, AlongPath::stretches, [&](std::size_t from, std::size_t to, std::size_t part) {
      const Eigen::Map<const Eigen::MatrixXd> squares = errors_.squares(from, to);
      result_.path.add(squares, to - from, part);
      variance_ = squares.rowwise().sum();
      in_parts(first + from, to - from, job_.blocks, [&](std::size_t a, std::size_t b, std::size_t block) {
        if (b - a != to - from) variance_ = errors_.squares(from + a, from + b).rowwise().sum();
        result_.outputs[0].expect(variance_, block);
        for (std::size_t f = 0; f < filters_.size(); ++f)
          if (job_.every[f] == 1) result_.outputs[f + 1].expect(variance_, block);
      });
    });
    for (std::size_t f = 0; f < filters_.size(); ++f)
      if (job_.every[f] > 1) expect_some(first, count, job_.every[f], result_.outputs[f + 1]);
  }

  /// The same of every n-th sample.
  void expect_some(std::uint64_t first, std::size_t count, std::uint64_t every, RunStatistics& output) {
    in_parts(first, count, job_.blocks, [&](std::size_t from, std::size_t to, std::size_t block) {
      for (std::size_t i = from; i < to; ++i)
        if ((first + i) % every == 0) output.expect(errors_.squares(i, i + 1).rowwise().sum().array(), block);
    });
  }

  const Job& job_;
  Channels channels_;
  bool visited_;
  Sensing sensing_;
  PathErrors errors_;
  const SimulationKernels& kernels_;
  AlignedNumbers room_;  // of the statistics
  Eigen::ArrayXd variance_;
  std::vector<ChannelFilter> filters_;
  RunResult result_;
};

}  // namespace

RunResult run(const Job& job, std::uint64_t index, const std::function<void()>& tick) {
  return Run(job, index)(tick);
}

}  // namespace qerr
