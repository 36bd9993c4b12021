// The parts of the main job, one by one, on the arm of configs/kuka_lwr.
//
//   cmake -S . -B build -G Ninja -DQERR_BENCH=ON && ninja -C build bench_parts && build/tests/bench_parts
//
// `items_per_second` are configurations, of `accumulate` values.

#include <benchmark/benchmark.h>

#include "qerr/bound/operational_error.hpp"
#include "qerr/bound/statistic.hpp"
#include "qerr/core/random.hpp"
#include "qerr/input/spec.hpp"

namespace {

using namespace qerr;

constexpr Eigen::Index points = 4096;

const Spec& spec() {
  static const Spec one = read_spec(QERR_SOURCE_DIR "/configs/kuka_lwr/spec.yaml");
  return one;
}

/// Calls `part(q)` for point after point.
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

/// One figure into its statistic.
/// @param expected  how many the Accumulator is told to expect: beyond its limit it counts in bins
void accumulate(benchmark::State& state, std::uint64_t expected) {
  std::vector<double> values;
  for (std::uint64_t i = 0; i < points; ++i) values.push_back(1e-4 * unit_interval(random_bits(1, i, 0)));
  const Eigen::VectorXd q = Eigen::VectorXd::Zero(7);
  for (auto _ : state) {
    state.PauseTiming();  // memory of exact values must not grow from one round to the next
    Accumulator all(expected);
    state.ResumeTiming();
    for (const double value : values) all.add(value, q);
    benchmark::DoNotOptimize(all);
  }
  state.SetItemsProcessed(state.iterations() * points);
}

BENCHMARK(pose);
BENCHMARK(tip_jacobian);
BENCHMARK(bounds);
BENCHMARK(bounds_and_covariance);
BENCHMARK_CAPTURE(sample, sobol, SamplingMethod::sobol);
BENCHMARK_CAPTURE(sample, random, SamplingMethod::random);
BENCHMARK_CAPTURE(sample, grid, SamplingMethod::grid);
BENCHMARK_CAPTURE(accumulate, exact, 1);
BENCHMARK_CAPTURE(accumulate, in_bins, Accumulator::exact_limit + 1);

}  // namespace

BENCHMARK_MAIN();
