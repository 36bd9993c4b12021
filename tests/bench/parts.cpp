// Times the parts of `analyze` separately, on the arm of configs/kuka_lwr.
//
//   cmake -S . -B build -G Ninja -DQERR_BENCH=ON && ninja -C build bench_parts &&
//   build/tests/bench/bench_parts
//
// `items_per_second` are configurations; for `histogram`, values. The number after a slash is the instruction
// set: 0 portable, 1 avx2, 2 avx512.

#include <benchmark/benchmark.h>

#include "bound/batched_error.hpp"
#include "bound/histogram.hpp"
#include "core/random.hpp"
#include "kinematics/sampler.hpp"
#include "lanes/batch.hpp"
#include "qerr/bound/operational_error.hpp"
#include "qerr/input/spec.hpp"

namespace {

using namespace qerr;

constexpr Eigen::Index points = 4096;

const Spec& spec() {
  static const Spec one = read_spec(QERR_SOURCE_DIR "/configs/kuka_lwr/spec.yaml");
  return one;
}

/// Calls `part(q)` for each point.
template <typename Part>
void for_each_configuration(benchmark::State& state, Part part) {
  static const Eigen::MatrixXd all = draw(spec().configurations, 0, points);
  Eigen::Index i = 0;
  for (auto _ : state) {
    const Eigen::VectorXd q = all.col(i++ % points);
    benchmark::DoNotOptimize(part(q));
  }
  state.SetItemsProcessed(state.iterations());
}

void pose(benchmark::State& state) {
  for_each_configuration(state, [](const auto& q) { return forward_kinematics(spec().model.chain, q); });
}
void tip_jacobian(benchmark::State& state) {
  for_each_configuration(state, [](const auto& q) { return jacobian(spec().model.chain, q); });
}
void bounds(benchmark::State& state) {
  for_each_configuration(state, [](const auto& q) { return operational_error(spec().model, q); });
}
void bounds_and_covariance(benchmark::State& state) {
  for_each_configuration(state, [](const auto& q) { return covariance(operational_error(spec().model, q)); });
}

/// Blocks of configurations, as workspace() draws them.
void sample(benchmark::State& state, SamplingMethod method) {
  Configurations c = spec().configurations;
  c.method = method;
  c.count = method == SamplingMethod::grid ? 100 : std::uint64_t{1} << 40;
  std::uint64_t first = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(draw(c, first, points));
    first += points;
  }
  state.SetItemsProcessed(state.iterations() * points);
}

/// Buffers for a batch of configurations and its results.
struct Batch {
  AlignedNumbers q{spec().model.chain.independent.size() * batch_size};
  AlignedNumbers columns{6 * spec().model.chain.joints.size() * batch_size};
  AlignedNumbers figures{64 * batch_size};
};

/// Calls `part(batch, index of the first configuration)` for each batch.
template <typename Part>
void for_each_batch(benchmark::State& state, Part part) {
  Batch batch;
  Sampler(spec().configurations)(0, batch.q.data());
  std::uint64_t first = 0;
  for (auto _ : state) {
    part(batch, first);
    benchmark::ClobberMemory();
    first += batch_size;
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(batch_size));
}

InstructionSet instructions(const benchmark::State& state) {
  return available_instruction_sets()[static_cast<std::size_t>(state.range(0))];
}

void batched_sample(benchmark::State& state, SamplingMethod method) {
  Configurations c = spec().configurations;
  c.method = method;
  c.count = method == SamplingMethod::grid ? 1000 : std::uint64_t{1} << 40;
  Sampler sampler(c, instructions(state));
  for_each_batch(state, [&](Batch& b, std::uint64_t first) { sampler(first, b.q.data()); });
}

void batched_jacobian(benchmark::State& state) {
  BatchedJacobian jacobian(spec().model.chain, instructions(state));
  for_each_batch(state, [&](Batch& b, std::uint64_t) { jacobian(b.q.data(), b.columns.data()); });
}

void batched_bounds(benchmark::State& state, bool all) {
  BatchedError errors(spec().model, {.rigorous = all, .shares = all}, instructions(state));
  for_each_batch(state, [&](Batch& b, std::uint64_t) { errors(b.q.data(), b.figures.data()); });
}

/// Values of one figure into its histogram.
void histogram(benchmark::State& state) {
  std::vector<std::int32_t> bins;
  for (std::uint64_t i = 0; i < points; ++i)
    bins.push_back(leading_bits(1e-4 * unit_interval(random_bits(1, i, 0))));
  Histogram all(Histogram::lowest_bin(leading_bits(1e-4)));
  for (auto _ : state) all.add(bins.data(), bins.size(), 0, 0);
  state.SetItemsProcessed(state.iterations() * points);
}

void per_instruction_set(benchmark::internal::Benchmark* b) {
  b->DenseRange(0, static_cast<int>(available_instruction_sets().size()) - 1);
}

BENCHMARK(pose);
BENCHMARK(tip_jacobian);
BENCHMARK(bounds);
BENCHMARK(bounds_and_covariance);
BENCHMARK_CAPTURE(sample, sobol, SamplingMethod::sobol);
BENCHMARK_CAPTURE(sample, random, SamplingMethod::random);
BENCHMARK_CAPTURE(sample, grid, SamplingMethod::grid);
BENCHMARK_CAPTURE(batched_sample, sobol, SamplingMethod::sobol)->Apply(per_instruction_set);
BENCHMARK_CAPTURE(batched_sample, random, SamplingMethod::random)->Apply(per_instruction_set);
BENCHMARK_CAPTURE(batched_sample, grid, SamplingMethod::grid)->Apply(per_instruction_set);
BENCHMARK(batched_jacobian)->Apply(per_instruction_set);
BENCHMARK_CAPTURE(batched_bounds, worst_case_and_sigma, false)->Apply(per_instruction_set);
BENCHMARK_CAPTURE(batched_bounds, everything, true)->Apply(per_instruction_set);
BENCHMARK(histogram);

}  // namespace

BENCHMARK_MAIN();
